#pragma once

#include "cli/products/points_csv.h"
#include "common/solution/run_folder.h"
#include "common/support/result.h"

#include <filesystem>
#include <string>
#include <vector>

/// `measure`: illuminance at points of surfaces (docs/estimates.md).
namespace lumenfarm {

struct Measurement {
    std::string csv;                    ///< head x,y,z,illuminance_lx,standard_error_lx,hits, then a row a point
    std::vector<std::string> warnings;  ///< points without a surface: their last three values are empty
};

/// A point belongs to the nearest surface within 1 mm or a thousandth of the scene's diagonal. Without a normal the
/// side that receives more is taken. `name` stands in the warnings.
Measurement measure(const LoadedRun& run, const std::vector<AskedPoint>& points, const std::string& name);

/// Reads points and writes the CSV, whole or not at all. Gives the warnings. Errors: bad_input (points), failed
/// (output).
Result<std::vector<std::string>> measure_file(const LoadedRun& run, const std::filesystem::path& points,
                                              const std::filesystem::path& output);

}  // namespace lumenfarm
