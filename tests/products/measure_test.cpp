#include "cli/products/measure.h"

#include "tests/solution/synthetic.h"
#include "tests/solution/traced_run.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace lumenfarm {
namespace {

struct Row {
    double x, y, z, lux, error;
    unsigned long long hits;
};

std::vector<Row> rows_of(const std::string& csv) {
    std::istringstream lines(csv);
    std::string line;
    std::getline(lines, line);
    EXPECT_EQ(line, "x,y,z,illuminance_lx,standard_error_lx,hits");
    std::vector<Row> rows;
    while (std::getline(lines, line)) {
        Row row{};
        EXPECT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf,%lf,%llu", &row.x, &row.y, &row.z, &row.lux, &row.error,
                              &row.hits),
                  6)
            << line;
        rows.push_back(row);
    }
    return rows;
}

/// CIE 171 case 5.2: a Lambertian point of 1000 cd 3 m above a floor of 6 x 6 m.
LoadedRun cie_5_2(std::uint64_t particles, std::uint64_t keep_hits) {
    test::QuadScene quads;
    quads.quad("floor", {-3, 0, -3}, {0, 0, 6}, {6, 0, 0}, quads.lambert(0.3));
    quads.point_light({0, 3, 0}, 1'000, true);
    JobSpec spec;
    spec.particles = particles;
    spec.keep_hits = keep_hits;
    return test::traced_run(quads.scene, spec);
}

void expect_cie_5_2(const LoadedRun& run) {
    std::vector<AskedPoint> points;
    for (const auto& [x, z] : {std::pair{0.0, 0.0}, {0.5, 0.0}, {1.0, 0.0}, {1.5, 0.0}, {1.0, 1.0}, {1.5, 1.5}})
        points.push_back({{x, 0, z}, Vec3d{0, 1, 0}, 1});
    points.push_back({{-3, 0, -3}, std::nullopt, 1});  // a corner, and no normal: the lit side
    const auto rows = rows_of(measure(run, points, "points").csv);
    ASSERT_EQ(rows.size(), 7u);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const Row& row = rows[i];
        const double truth = 9'000 / std::pow(9 + row.x * row.x + row.z * row.z, 2);
        EXPECT_NEAR(row.lux, truth, 4 * row.error) << row.x << " " << row.z;
        if (i < 6) {
            EXPECT_LT(row.error, 0.01 * truth) << row.x << " " << row.z;
        }
    }
}

TEST(Measure, Cie171Case52HoldsByTexels) { expect_cie_5_2(cie_5_2(4'000'000, 0)); }

TEST(Measure, Cie171Case52HoldsByKeptHits) { expect_cie_5_2(cie_5_2(4'000'000, 4'000'000)); }

TEST(Measure, StatedErrorsAreTheSpreadOverSeeds) {
    test::QuadScene quads;
    quads.quad("floor", {-3, 0, -3}, {0, 0, 6}, {6, 0, 0}, quads.lambert(0.3));
    quads.point_light({0, 3, 0}, 1'000, true);
    double chi2 = 0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        JobSpec spec;
        spec.particles = 20'000;
        spec.seed = seed;
        const LoadedRun run = test::traced_run(quads.scene, spec);
        const auto rows = rows_of(measure(run, {{{1, 0, 0}, Vec3d{0, 1, 0}, 1}}, "points").csv);
        chi2 += std::pow((rows.at(0).lux - 90) / rows.at(0).error, 2);
    }
    EXPECT_LT(chi2, 40 + 4 * std::sqrt(80.0));  // Sobol starts spread less than independent hits: no lower bound
}

TEST(Measure, APointWithoutASurfaceIsLeftEmptyWithAWarning) {
    const LoadedRun run = test::empty_run(test::sheet_scene(), JobSpec{});
    const auto measured = measure(run, {{{0, 0.8, 0}, std::nullopt, 4}, {{0, 0, 0}, Vec3d{1, 0, 0}, 5}}, "pts.csv");
    EXPECT_EQ(measured.csv, "x,y,z,illuminance_lx,standard_error_lx,hits\n0,0.8,0,,,\n0,0,0,,,\n");
    ASSERT_EQ(measured.warnings.size(), 2u);
    EXPECT_NE(measured.warnings[0].find("'pts.csv' line 4"), std::string::npos);
}

TEST(Points, ReadsRowsWithAndWithoutNormals) {
    const auto points = parse_points("# plan\r\nx,y,z\r\n 1, +2.5,-3e-1\r\n\n0,0,0,0,0,2\n", "p");
    ASSERT_TRUE(points) << points.error().sentence;
    ASSERT_EQ(points->size(), 2u);
    EXPECT_EQ(points->at(0).position, (Vec3d{1, 2.5, -0.3}));
    EXPECT_FALSE(points->at(0).normal);
    EXPECT_EQ(points->at(0).line, 3u);
    EXPECT_EQ(*points->at(1).normal, (Vec3d{0, 0, 1}));
}

TEST(Points, BadRowsAreNamedByLineAndValue) {
    const std::pair<const char*, const char*> cases[] = {
        {"1,2\n", "line 1 has 2"},
        {"1,2,3\n4,5,6,7\n", "line 2 has 4"},
        {"1,2,three\n", "'three'"},
        {"1,2,nan\n", "'nan'"},
        {"1,2,inf\n", "'inf'"},
        {"1,2,1e400\n", "'1e400'"},
        {"1,2,3e9\n", "'3e9'"},
        {"1,,3\n", "''"},
        {"1,2,3,0,0,0\n", "normal"},
        {"1,2,3,4,5,6,7,8,9\n", "line 1 has more"},
        {"1,2,0x10\n", "'0x10'"},
        {"1,2,3 4\n", "'3 4'"},
        {"", "no points"},
        {"x,y,z\n", "no points"},
        {"x,y,z\nx,y,z\n", "line 2: 'x'"},
        {"\x1b[31m,2,3\n", "'?[31m'"},
    };
    for (const auto& [text, part] : cases) {
        const auto points = parse_points(text, "pts.csv");
        ASSERT_FALSE(points) << text;
        EXPECT_EQ(points.error().code, ErrorCode::bad_input);
        EXPECT_NE(points.error().sentence.find(part), std::string::npos) << points.error().sentence;
    }
    const auto binary = parse_points(std::string(100'000, '\0'), "pts.csv");
    ASSERT_FALSE(binary);
    EXPECT_LT(binary.error().sentence.size(), 200u);
}

TEST(Measure, FilesAreReadAndWrittenOrRefused) {
    const auto folder = std::filesystem::path(testing::TempDir()) / "lumenfarm_measure";
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "pts.csv") << "0,0,0,0,1,0\n0,5,0\n";
    const LoadedRun run = test::empty_run(test::sheet_scene(), JobSpec{});
    const auto warnings = measure_file(run, folder / "pts.csv", folder / "lux.csv");
    ASSERT_TRUE(warnings) << warnings.error().sentence;
    EXPECT_EQ(warnings->size(), 1u);
    EXPECT_TRUE(std::filesystem::exists(folder / "lux.csv"));
    EXPECT_FALSE(measure_file(run, folder / "none.csv", folder / "lux2.csv"));
    EXPECT_FALSE(std::filesystem::exists(folder / "lux2.csv"));
    const auto unwritable = measure_file(run, folder / "pts.csv", folder / "no" / "lux.csv");
    ASSERT_FALSE(unwritable);
    EXPECT_EQ(unwritable.error().code, ErrorCode::failed);
    std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace lumenfarm
