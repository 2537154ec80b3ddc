#include "cli/products/measure.h"

#include "common/solution/point_light.h"
#include "common/support/file.h"
#include "common/support/limits.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace lumenfarm {
namespace {

constexpr double tolerance_m = 1e-3;
constexpr double tolerance_of_scene = 1e-3;

std::string number_text(double number) {
    std::array<char, 32> digits{};
    return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr};
}

std::string place_text(Vec3d p) { return number_text(p.x) + "," + number_text(p.y) + "," + number_text(p.z); }

std::string row_text(Vec3d position, const PointEstimate& estimate) {
    std::string row = place_text(position) + "," + number_text(std::max(estimate.xyz_lx.y, 0.0)) + ",";
    if (std::isfinite(estimate.standard_error_lx)) row += number_text(estimate.standard_error_lx);
    return row + "," + std::to_string(estimate.hits) + "\n";
}

double tolerance_for(const Scene& scene) {
    const Box box = bounding_box(scene);
    return std::max(tolerance_m, box.empty() ? 0 : tolerance_of_scene * length(box.high - box.low));
}

}  // namespace

Measurement measure(const LoadedRun& run, const std::vector<AskedPoint>& points, const std::string& name) {
    const TriangleIndex index(run.scene);
    const TickValue tick = tick_value(run.emission, run.solution);
    const TexelFit texels(run.scene, index, run.layout, run.solution, tick);
    const NearestHits hits(run.scene, index, run.solution, tick);
    const double tolerance = tolerance_for(run.scene);
    Measurement measurement{"x,y,z,illuminance_lx,standard_error_lx,hits\n", {}};
    for (const AskedPoint& asked : points) {
        const auto found = find_surface_points(run.scene, index, asked.position, asked.normal, tolerance);
        if (found.empty()) {
            measurement.csv += place_text(asked.position) + ",,,\n";
            measurement.warnings.push_back("'" + name + "' line " + std::to_string(asked.line) + ": no surface " +
                                           (asked.normal ? "across the normal " : "") + "lies within " +
                                           number_text(tolerance) + " m of " + place_text(asked.position));
            continue;
        }
        measurement.csv += row_text(asked.position, estimate_brighter(texels, hits, found).estimate);
    }
    return measurement;
}

Result<std::vector<std::string>> measure_file(const LoadedRun& run, const std::filesystem::path& points,
                                              const std::filesystem::path& output) {
    const auto bytes = read_file(points, limits::points_file_bytes_max);
    if (!bytes) return bytes.error();
    const std::string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
    const auto asked = parse_points(text, points.string());
    if (!asked) return asked.error();
    Measurement measurement = measure(run, *asked, points.string());
    if (const auto written = write_file(output, measurement.csv); !written) return written.error();
    return std::move(measurement.warnings);
}

}  // namespace lumenfarm
