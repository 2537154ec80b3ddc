#include "cli/bench/farm_report.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <set>

namespace lumenfarm {

namespace json = boost::json;

namespace {

constexpr const char* csv_head =
    "run,workers,particles,hits_per_message,packing,total_s,trace_s,master_cpu_s,worker_cpu_s,hits,bytes_from_workers,"
    "bytes_to_workers,messages_from_workers,messages_to_workers,relays,relay_cpu_s,jobs,ideal_s,digest\n";

std::string seconds(double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.6f", value);
    return text.data();
}

/// "205,000 particles"
std::string particles_name(std::uint64_t particles) {
    const std::string digits = std::to_string(particles);
    std::string name;
    for (std::size_t i = 0; i < digits.size(); ++i) {
        if (i > 0 && (digits.size() - i) % 3 == 0) name += ',';
        name += digits[i];
    }
    return name + " particles";
}

json::object document(const FarmRun& run) {
    return {{"run", run.run},
            {"workers", run.workers},
            {"particles", run.particles},
            {"hits_per_message", run.hits_per_message},
            {"packing", name_of(run.packing)},
            {"total_s", run.total_s},
            {"trace_s", run.trace_s},
            {"master_cpu_s", run.master_cpu_s},
            {"worker_cpu_s", run.worker_cpu_s},
            {"hits", run.hits},
            {"bytes_from_workers", run.traffic.bytes_in},
            {"bytes_to_workers", run.traffic.bytes_out},
            {"messages_from_workers", run.traffic.messages_in},
            {"messages_to_workers", run.traffic.messages_out},
            {"relays", run.relays},
            {"relay_cpu_s", run.relay_cpu_s},
            {"jobs", run.jobs},
            {"ideal_s", run.ideal_s},
            {"digest", run.digest.hex()}};
}

json::object document(const FarmBenchRow& row) {
    return {{"workers", row.workers},
            {"particles", row.particles},
            {"hits_per_message", row.hits_per_message},
            {"packing", name_of(row.packing)},
            {"total_s", row.total_s},
            {"trace_s", row.trace_s},
            {"speed_up_total", row.speed_up_total},
            {"speed_up_trace", row.speed_up_trace},
            {"efficiency", row.efficiency},
            {"particles_per_s", row.particles_per_s},
            {"bytes_per_particle", row.bytes_per_particle},
            {"master_cpu_per_worker_cpu", row.master_cpu_per_worker_cpu}};
}

using Value = double FarmBenchRow::*;

LineChart over_workers(std::span<const FarmBenchRow> rows, std::string title, Value value, bool ideal_is_workers) {
    LineChart chart{std::move(title), "workers", ideal_is_workers ? "speed-up" : "efficiency", false, {}};
    LineChart::Series ideal{"ideal", {}, true};
    std::map<std::uint64_t, LineChart::Series> curves;
    std::set<double> workers;
    for (const FarmBenchRow& row : rows) {
        LineChart::Series& curve = curves[row.particles];
        curve.name = particles_name(row.particles);
        curve.points.push_back({static_cast<double>(row.workers), row.*value});
        workers.insert(row.workers);
    }
    for (const double n : workers) ideal.points.push_back({n, ideal_is_workers ? n : 1.0});
    chart.series.push_back(std::move(ideal));
    for (auto& [particles, curve] : curves) {
        std::ranges::sort(curve.points, {}, &LineChart::Point::x);
        chart.series.push_back(std::move(curve));
    }
    return chart;
}

LineChart over_hits_per_message(std::span<const FarmBenchRow> rows) {
    LineChart chart{"Rate over the granularity of packing", "hits in a message", "particles a second", true, {}};
    std::map<std::pair<std::uint64_t, std::uint32_t>, LineChart::Series> curves;
    for (const FarmBenchRow& row : rows) {
        LineChart::Series& curve = curves[{row.particles, row.workers}];
        curve.name = particles_name(row.particles) + ", " + std::to_string(row.workers) +
                     (row.workers == 1 ? " worker" : " workers");
        curve.points.push_back({static_cast<double>(row.hits_per_message), row.particles_per_s});
    }
    for (auto& [key, curve] : curves) {
        std::ranges::sort(curve.points, {}, &LineChart::Point::x);
        chart.series.push_back(std::move(curve));
    }
    return chart;
}

}  // namespace

std::string csv_text(std::span<const FarmRun> runs) {
    std::string text = csv_head;
    for (const FarmRun& run : runs) {
        text += std::to_string(run.run) + "," + std::to_string(run.workers) + "," + std::to_string(run.particles) +
                "," + std::to_string(run.hits_per_message) + "," + std::string(name_of(run.packing)) + "," +
                seconds(run.total_s) + "," + seconds(run.trace_s) + "," + seconds(run.master_cpu_s) + "," +
                seconds(run.worker_cpu_s) + "," + std::to_string(run.hits) + "," +
                std::to_string(run.traffic.bytes_in) + "," + std::to_string(run.traffic.bytes_out) + "," +
                std::to_string(run.traffic.messages_in) + "," + std::to_string(run.traffic.messages_out) + "," +
                std::to_string(run.relays) + "," + seconds(run.relay_cpu_s) + "," + std::to_string(run.jobs) + "," +
                seconds(run.ideal_s) + "," + run.digest.hex() + "\n";
    }
    return text;
}

json::object document(std::span<const FarmRun> runs, std::span<const FarmBenchRow> rows) {
    json::array all, medians;
    for (const FarmRun& run : runs) all.push_back(document(run));
    for (const FarmBenchRow& row : rows) medians.push_back(document(row));
    return {{"runs", std::move(all)}, {"medians", std::move(medians)}};
}

std::string table(std::span<const FarmBenchRow> rows) {
    std::array<char, 256> line{};
    std::snprintf(line.data(), line.size(), "%12s %9s %8s %8s %10s %10s %9s %9s %10s %11s %10s\n", "particles",
                  "hits/msg", "packing", "workers", "total s", "tracing s", "speed-up", "(tracing)", "efficiency",
                  "B/particle", "master CPU");
    std::string text = line.data();
    for (const FarmBenchRow& row : rows) {
        std::snprintf(line.data(), line.size(), "%12llu %9u %8s %8u %10.4f %10.4f %9.3f %9.3f %10.3f %11.2f %10.4f\n",
                      static_cast<unsigned long long>(row.particles), row.hits_per_message,
                      std::string(name_of(row.packing)).c_str(), row.workers, row.total_s, row.trace_s,
                      row.speed_up_total, row.speed_up_trace, row.efficiency, row.bytes_per_particle,
                      row.master_cpu_per_worker_cpu);
        text += line.data();
    }
    return text;
}

std::vector<NamedChart> charts_of(std::span<const FarmBenchRow> rows) {
    const auto differs = [&](const FarmBenchRow& row) { return row.hits_per_message != rows.front().hits_per_message; };
    if (std::ranges::any_of(rows, differs)) return {{"hits-per-message", over_hits_per_message(rows)}};
    return {
        {"speed-up-total", over_workers(rows, "Speed-up of total time", &FarmBenchRow::speed_up_total, true)},
        {"speed-up-tracing", over_workers(rows, "Speed-up of pure tracing time", &FarmBenchRow::speed_up_trace, true)},
        {"efficiency", over_workers(rows, "Efficiency", &FarmBenchRow::efficiency, false)}};
}

}  // namespace lumenfarm
