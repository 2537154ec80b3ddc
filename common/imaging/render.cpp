#include "common/imaging/render.h"

#include "common/support/limits.h"
#include "common/transport/fresnel.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace lumenfarm {
namespace {

constexpr double pi = 3.14159265358979323846;
constexpr std::uint32_t camera_bin = 2'075;  // 587.55 nm, the d line: camera paths see no dispersion
constexpr std::uint32_t split_depth = 4;     // both ways of a glass boundary are followed so deep, then one
constexpr std::uint32_t depth_max = 32;      // bends of a camera path
constexpr double weight_min = 2e-3;          // paths that matter less end

double luminance(Vec3d rgb) { return 0.2126 * rgb.x + 0.7152 * rgb.y + 0.0722 * rgb.z; }
Vec3d times(Vec3d a, Vec3d b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
double largest(Vec3d v) { return std::max({v.x, v.y, v.z}); }

/// A deterministic number in [0, 1) for a choice along a path [Steele et al. 2014, SplitMix64].
class Choices {
public:
    explicit Choices(std::uint64_t seed) : state_(seed) {}
    double next() {
        std::uint64_t z = state_ += 0x9e3779b97f4a7c15u;
        z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
        z = (z ^ z >> 27) * 0x94d049bb133111ebu;
        return static_cast<double>((z ^ z >> 31) >> 11) * 0x1p-53;
    }

private:
    std::uint64_t state_;
};

/// What the rays of one pixel have seen.
struct Seen {
    Vec3d radiance;
    double share = 0;  ///< of diffuse surfaces, by weight; the sums below are weighted with it
    double illuminance = 0, relative_error = 0, hits = 0;
};

struct CameraRay {
    Vec3d origin, direction;
    std::uint32_t from_triangle = none;
    Vec3d weight{1, 1, 1};
    std::uint32_t depth = 0;
};

class PixelRenderer {
public:
    PixelRenderer(const LoadedRun& run, const TracerScene& tracer, const Appearance& appearance,
                  const IncidentLight& light)
        : run_(run), tracer_(tracer), appearance_(appearance), light_(light) {}

    Pixel pixel(const View& view, std::uint32_t column, std::uint32_t row, std::uint32_t per_side) {
        last_.reset();  // nothing passes from pixel to pixel, so their order does not matter
        Seen seen;
        for (std::uint32_t i = 0; i < per_side * per_side; ++i) {
            Choices choices((std::uint64_t{row} << 40) ^ (std::uint64_t{column} << 16) ^ i);
            const double x = column + (i % per_side + 0.5) / per_side, y = row + (i / per_side + 0.5) / per_side;
            follow({view.origin(), view.direction(x, y)}, choices, seen);
        }
        return finish(seen, per_side * per_side);
    }

private:
    static Pixel finish(const Seen& seen, std::uint32_t rays) {
        Pixel pixel;
        pixel.radiance = (seen.radiance * (1.0 / rays)).as<float>();
        if (!(seen.share > 0)) return pixel;
        pixel.illuminance_lx = static_cast<float>(seen.illuminance / seen.share);
        pixel.relative_error = static_cast<float>(seen.relative_error / seen.share);
        pixel.hit_count = static_cast<float>(seen.hits / seen.share);
        return pixel;
    }

    void follow(const CameraRay& first, Choices& choices, Seen& seen) {
        waiting_.assign(1, first);
        while (!waiting_.empty()) {
            const CameraRay ray = waiting_.back();
            waiting_.pop_back();
            const auto meeting = tracer_.meet(ray.origin, ray.direction, ray.from_triangle);
            if (meeting.triangle != none) meet(ray, meeting, choices, seen);
        }
    }

    void meet(const CameraRay& ray, const TracerScene::Meeting& meeting, Choices& choices, Seen& seen) {
        const std::uint32_t side = meeting.back ? 1 : 0;
        const SurfacePoint point = point_on_triangle(run_.scene, meeting.triangle, meeting.b1, meeting.b2, side);
        const Vec3d emitted = appearance_.emitted(appearance_.surface_of(meeting.triangle), side);
        seen.radiance = seen.radiance + times(ray.weight, emitted);
        const Material& material = appearance_.material_of(meeting.triangle);
        const Vec2f uv = appearance_.uv_at(meeting.triangle, meeting.b1, meeting.b2);
        const double glass = static_cast<double>(material.dielectric);
        if (glass < 1) {
            show_diffuse(ray.weight * (1 - glass), point, material, uv, seen);
            reflect(ray, point, times(ray.weight, appearance_.albedo(material.mirror, uv)) * (1 - glass));
        }
        if (glass > 0) pass_glass(ray, point, material, uv, choices);
    }

    void show_diffuse(Vec3d weight, const SurfacePoint& point, const Material& material, Vec2f uv, Seen& seen) {
        const Vec3d albedo = appearance_.albedo(material.diffuse, uv);
        if (!(largest(albedo) > 0)) return;
        if (!last_ || !light_.reusable(*last_, point)) last_ = light_.at(point);
        const PointEstimate& estimate = last_->estimate;
        seen.radiance = seen.radiance + times(weight, light_.reflected(*last_, material.diffuse, uv)) * (1 / pi);
        const double share = luminance(weight);
        const double error = estimate.standard_error_lx / estimate.xyz_lx.y;
        seen.share += share;
        seen.illuminance += share * estimate.xyz_lx.y;
        seen.relative_error += share * (std::isfinite(error) ? std::min(error, 1.0) : 1.0);
        seen.hits += share * static_cast<double>(estimate.hits);
    }

    void send(const CameraRay& from, const SurfacePoint& point, Vec3d direction, Vec3d weight) {
        if (from.depth + 1 >= depth_max || !(largest(weight) > weight_min)) return;
        waiting_.push_back({point.position, direction, point.triangle, weight, from.depth + 1});
    }

    void reflect(const CameraRay& ray, const SurfacePoint& point, Vec3d weight) {
        send(ray, point, ray.direction - point.normal * (2 * dot(ray.direction, point.normal)), weight);
    }

    void pass_glass(const CameraRay& ray, const SurfacePoint& point, const Material& material, Vec2f uv,
                    Choices& choices) {
        const double cos_incident = std::clamp(-dot(ray.direction, point.normal), 1e-9, 1.0);
        const double n = appearance_.materials().refractive_index(material, camera_bin);
        const double relative = point.side == 0 || material.thin ? n : 1 / n;
        const FresnelSplit split = fresnel(cos_incident, relative);
        const double reflectance = material.thin ? sheet_reflectance(split.reflectance) : split.reflectance;
        const Vec3d weight = ray.weight * static_cast<double>(material.dielectric);
        const Vec3d tinted = times(weight, appearance_.albedo(material.transmission, uv));
        const bool both = ray.depth < split_depth;
        const bool reflected = both || choices.next() < reflectance;
        if (reflected) reflect(ray, point, weight * (both ? reflectance : 1));
        if (reflected && !both) return;
        const double through = both ? 1 - reflectance : 1;
        if (!(through > 0)) return;
        if (material.thin) {
            send(ray, point, ray.direction, tinted * through);
            return;
        }
        const Vec3d bent =
            ray.direction * (1 / relative) + point.normal * (cos_incident / relative - split.cos_transmitted);
        // radiance over n^2 is what stays the same along a ray [Nicodemus 1963]
        send(ray, point, normalize(bent), tinted * (through / (relative * relative)));
    }

    const LoadedRun& run_;
    const TracerScene& tracer_;
    const Appearance& appearance_;
    const IncidentLight& light_;
    std::optional<IncidentLight::Local> last_;
    std::vector<CameraRay> waiting_;
};

Result<void> check(const Camera& camera, const RenderOptions& options) {
    if (options.width == 0 || options.height == 0 || options.width > limits::picture_side_max ||
        options.height > limits::picture_side_max)
        return bad_input("a picture of " + std::to_string(options.width) + "x" + std::to_string(options.height) +
                         " pixels; each side must be from 1 to " + std::to_string(limits::picture_side_max));
    if (options.samples_per_side == 0 || options.samples_per_side > limits::samples_per_side_max)
        return bad_input("there are " + std::to_string(options.samples_per_side) +
                         " samples along a pixel; they must be from 1 to " +
                         std::to_string(limits::samples_per_side_max));
    const double fov = camera.vertical_fov_degrees;
    if (!(fov > 0 && fov < 180))
        return bad_input("the field of view is " + std::to_string(fov) + " degrees; it must lie between 0 and 180");
    const double sideways = length(cross(camera.forward, camera.up));
    if (!(sideways > 1e-9 * length(camera.forward) * length(camera.up)) || !std::isfinite(sideways) ||
        !std::isfinite(length(camera.position)))
        return bad_input("camera '" + camera.name + "' has no direction, or looks along its own up");
    return {};
}

}  // namespace

Result<Picture> render(const LoadedRun& run, const TracerScene& tracer, const Camera& camera,
                       const RenderOptions& options) {
    if (const auto checked = check(camera, options); !checked) return checked.error();
    const Appearance appearance(run.scene, run.emission);
    const IncidentLight light(run, appearance, options.estimator);
    const View view(camera, options.width, options.height);
    Picture picture{options.width, options.height, {}};
    picture.pixels.resize(std::size_t{options.width} * options.height);

    std::atomic<std::uint32_t> next_row{0};
    const auto work = [&] {
        PixelRenderer renderer(run, tracer, appearance, light);
        for (std::uint32_t row = next_row++; row < options.height; row = next_row++)
            for (std::uint32_t column = 0; column < options.width; ++column)
                picture.pixels[std::size_t{row} * options.width + column] =
                    renderer.pixel(view, column, row, options.samples_per_side);
    };
    const std::uint32_t asked =
        options.threads > 0 ? options.threads : std::max(1u, std::thread::hardware_concurrency());
    std::vector<std::thread> helpers;
    for (std::uint32_t i = 1; i < std::min(asked, options.height); ++i) helpers.emplace_back(work);
    work();
    for (std::thread& helper : helpers) helper.join();
    return picture;
}

}  // namespace lumenfarm
