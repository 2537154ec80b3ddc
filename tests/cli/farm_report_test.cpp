#include "cli/bench/farm_report.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <sstream>

/// What `bench farm` makes of its runs.
namespace lumenfarm {
namespace {

FarmRun a_run(std::uint32_t workers, std::uint64_t particles, double total_s, std::uint32_t hits_per_message = 5'000) {
    FarmRun run;
    run.workers = workers;
    run.particles = particles;
    run.hits_per_message = hits_per_message;
    run.total_s = total_s;
    run.trace_s = total_s / 2;
    run.master_cpu_s = 0.1;
    run.worker_cpu_s = 4;
    run.traffic.bytes_in = 30 * particles;
    run.traffic.bytes_out = 10 * particles;
    return run;
}

const std::vector<FarmRun> six_runs{a_run(1, 1'000, 8), a_run(2, 1'000, 4),  a_run(1, 1'000, 100),
                                    a_run(2, 1'000, 5), a_run(1, 1'000, 10), a_run(2, 1'000, 1)};

std::size_t times(const std::string& text, const std::string& part) {
    std::size_t count = 0;
    for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
    return count;
}

TEST(FarmBenchRows, AreMediansComparedWithTheFewestWorkers) {
    const auto rows = rows_of(six_runs);
    ASSERT_EQ(rows.size(), 2u);
    EXPECT_DOUBLE_EQ(rows[0].total_s, 10);
    EXPECT_DOUBLE_EQ(rows[0].speed_up_total, 1);
    EXPECT_DOUBLE_EQ(rows[1].total_s, 4);
    EXPECT_DOUBLE_EQ(rows[1].trace_s, 2);
    EXPECT_DOUBLE_EQ(rows[1].speed_up_total, 2.5);
    EXPECT_DOUBLE_EQ(rows[1].speed_up_trace, 2.5);
    EXPECT_DOUBLE_EQ(rows[1].efficiency, 1.25);
    EXPECT_DOUBLE_EQ(rows[1].particles_per_s, 250);
    EXPECT_DOUBLE_EQ(rows[1].bytes_per_particle, 40);
    EXPECT_DOUBLE_EQ(rows[1].master_cpu_per_worker_cpu, 0.025);
}

TEST(FarmBenchRows, FewestWorkersCountAsPerfect) {
    const auto rows = rows_of(std::vector<FarmRun>{a_run(4, 500, 2), a_run(2, 500, 3), a_run(2, 900, 7)});
    ASSERT_EQ(rows.size(), 3u);
    EXPECT_DOUBLE_EQ(rows[0].speed_up_total, 3);
    EXPECT_DOUBLE_EQ(rows[1].speed_up_total, 2);
    EXPECT_DOUBLE_EQ(rows[2].efficiency, 1) << "other jobs are not compared";
}

TEST(FarmBenchRows, PacedWorkersAreComparedWithTheirPace) {
    FarmRun ten = a_run(10, 500, 12), forty = a_run(40, 500, 4);
    ten.ideal_s = 10;
    forty.ideal_s = 2.5;
    const auto rows = rows_of(std::vector{ten, forty});
    ASSERT_EQ(rows.size(), 2u);
    EXPECT_DOUBLE_EQ(rows[0].efficiency, 10.0 / 12);
    EXPECT_DOUBLE_EQ(rows[1].efficiency, 0.625);
    EXPECT_DOUBLE_EQ(rows[1].speed_up_total, 25);
}

TEST(FarmReport, EveryRunIsARowOfAllColumns) {
    std::istringstream lines(csv_text(six_runs));
    std::string head, line;
    std::getline(lines, head);
    std::size_t rows = 0;
    for (; std::getline(lines, line); ++rows) EXPECT_EQ(times(line, ","), times(head, ",")) << line;
    EXPECT_EQ(rows, six_runs.size());
    const auto json = document(six_runs, rows_of(six_runs));
    EXPECT_EQ(json.at("runs").as_array().size(), six_runs.size());
    EXPECT_EQ(json.at("medians").as_array().size(), 2u);
    EXPECT_EQ(times(table(rows_of(six_runs)), "\n"), 3u);
}

TEST(FarmReport, CurvesAreOverWorkersOrOverTheGranularity) {
    std::vector<std::string> names;
    for (const auto& [name, chart] : charts_of(rows_of(six_runs))) {
        names.push_back(name);
        ASSERT_EQ(chart.series.size(), 2u) << name << ": the ideal, and a number of particles";
        EXPECT_TRUE(chart.series[0].is_ideal);
        EXPECT_EQ(chart.series[1].name, "1,000 particles");
        EXPECT_EQ(chart.series[1].points.size(), 2u);
    }
    EXPECT_EQ(names, (std::vector<std::string>{"speed-up-total", "speed-up-tracing", "efficiency"}));
    const auto sweep = charts_of(rows_of(std::vector<FarmRun>{a_run(2, 500, 3, 100), a_run(2, 500, 2, 1)}));
    ASSERT_EQ(sweep.size(), 1u);
    EXPECT_TRUE(sweep[0].chart.log_x);
    EXPECT_EQ(sweep[0].chart.series.at(0).points.at(0).x, 1) << "ascending";
}

/// The places of a polyline or of circles.
std::vector<LineChart::Point> places(const std::string& svg, const std::string& pattern) {
    std::vector<LineChart::Point> all;
    const std::regex place(pattern);
    for (std::sregex_iterator at(svg.begin(), svg.end(), place), end; at != end; ++at)
        all.push_back({std::stod((*at)[1]), std::stod((*at)[2])});
    return all;
}

TEST(LineChart, PlacesFollowTheValues) {
    const LineChart chart{"a < b & c", "x", "y", true, {{"one", {{1, 0}, {10, 50}, {100, 100}}}}};
    const std::string svg = svg_text(chart);
    EXPECT_NE(svg.find("a &lt; b &amp; c"), std::string::npos);
    const auto marks = places(svg, R"re(<circle cx="([\d.]+)" cy="([\d.]+)")re");
    ASSERT_EQ(marks.size(), 3u);
    EXPECT_NEAR(marks[1].x - marks[0].x, marks[2].x - marks[1].x, 0.01) << "powers of ten stand equally far apart";
    EXPECT_NEAR(marks[0].y - marks[1].y, marks[1].y - marks[2].y, 0.01);
    EXPECT_GT(marks[0].y, marks[2].y) << "upwards";
    EXPECT_EQ(places(svg, R"re(([\d.]+),([\d.]+) )re").size(), 3u) << "the line goes through the same places";
}

TEST(LineChart, IdealIsDashedAndHasNoMarks) {
    LineChart chart{"t", "x", "y", false, {{"ideal", {{1, 1}, {2, 2}}, true}}};
    EXPECT_EQ(times(svg_text(chart), "stroke-dasharray"), 1u);
    EXPECT_EQ(times(svg_text(chart), "<circle"), 0u);
}

TEST(LineChart, WithoutPointsOrWithOneIsStillAPicture) {
    for (const std::vector<LineChart::Point>& points :
         {std::vector<LineChart::Point>{}, std::vector<LineChart::Point>{{3, 0}}}) {
        const std::string svg = svg_text({"t", "x", "y", false, {{"s", points}}});
        EXPECT_EQ(svg.find("nan"), std::string::npos);
        EXPECT_EQ(svg.find("inf"), std::string::npos);
        EXPECT_TRUE(svg.ends_with("</svg>\n"));
    }
}

}  // namespace
}  // namespace lumenfarm
