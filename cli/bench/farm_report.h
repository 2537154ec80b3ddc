#pragma once

#include "cli/bench/farm_bench.h"
#include "cli/bench/line_chart.h"

#include <boost/json/object.hpp>

#include <span>
#include <string>
#include <utility>
#include <vector>

/// What `bench farm` leaves for people and for scripts.
namespace lumenfarm {

/// A row for each run, with a head line: RFC 4180, seconds and bytes.
std::string csv_text(std::span<const FarmRun> runs);
/// {"runs": [...], "medians": [...]}
boost::json::object document(std::span<const FarmRun> runs, std::span<const FarmBenchRow> rows);
/// The medians, for a terminal.
std::string table(std::span<const FarmBenchRow> rows);

struct NamedChart {
    std::string name;  ///< of its file, without the extension
    LineChart chart;
};
/// Speed-up of total and of pure tracing time and efficiency over the number of workers, a curve for each number of
/// particles; where the hits of a message differ, particles a second over them instead.
std::vector<NamedChart> charts_of(std::span<const FarmBenchRow> rows);

}  // namespace lumenfarm
