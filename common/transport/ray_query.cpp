#include "common/transport/ray_query.h"

#include "common/support/ensure.h"
#include "common/support/huge_pages.h"
#include "common/transport/wide_registers.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace lumenfarm {
namespace {

// Lengths as fractions of the scene's half extent S. Embree computes in float (2^-24): its error across the ray stays
// around 2^-21 S, and grows along the plane of a triangle as 1 / cos of the angle of incidence.
constexpr double enlargement = 0x1p-17;      ///< by which each edge of Embree's triangles is moved outwards
constexpr double certain_inside = 0x1p-18;   ///< a candidate farther inside its true edges than this is met for certain
constexpr double distance_window = 0x1p-18;  ///< candidates closer to each other along the ray are compared in double
constexpr double near_distance = 0x1p-16;  ///< meetings closer to the origin are looked for only where near_edge is set
constexpr double near_edge = 0x1p-14;
constexpr float certain_cosine = 0.125f;  ///< more grazing candidates are decided in double
constexpr double origin_window = 1e-12;   ///< of S: meetings closer than this are the origin itself
constexpr double sliver_ratio = 4;        ///< enlarging by more than this factor needs the bounding parallelogram

struct DeviceRelease {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct SceneRelease {
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
using Device = std::unique_ptr<std::remove_pointer_t<RTCDevice>, DeviceRelease>;
using EmbreeScene = std::unique_ptr<std::remove_pointer_t<RTCScene>, SceneRelease>;

/// A triangle that contains all points of the plane within `delta` of the true one.
struct Enlarged {
    std::array<Vec3d, 3> corners;
    bool parallel;  ///< each edge was moved outwards by delta; false for slivers, which grow more
};
Enlarged enlarged(const std::array<Vec3d, 3>& p, double delta) {
    const double a = length(p[2] - p[1]);
    const double b = length(p[0] - p[2]);
    const double c = length(p[1] - p[0]);
    const double around = a + b + c;
    const double inradius = length(cross(p[1] - p[0], p[2] - p[0])) / around;
    // scaled about the incentre, every edge moves by delta
    if (delta < (sliver_ratio - 1) * inradius) {
        const Vec3d incentre = (p[0] * a + p[1] * b + p[2] * c) * (1 / around);
        const double scale = (inradius + delta) / inradius;
        return {{incentre + (p[0] - incentre) * scale, incentre + (p[1] - incentre) * scale,
                 incentre + (p[2] - incentre) * scale},
                true};
    }
    // a sliver: twice the rectangle along its longest edge, so that no corner runs far away
    const std::size_t longest = a >= b && a >= c ? 0 : b >= c ? 1 : 2;
    const Vec3d from = p[(longest + 1) % 3];
    const Vec3d along = normalize(p[(longest + 2) % 3] - from);
    const Vec3d apex = p[longest] - from;
    Vec3d across = apex - along * dot(apex, along);
    const double height = length(across);
    across = across * (1 / height);
    const Vec3d corner = from - along * delta - across * delta;
    return {{corner, corner + along * (2 * (std::max({a, b, c}) + 2 * delta)),
             corner + across * (2 * (height + 2 * delta))},
            false};
}

class EmbreeQuery;

struct Candidate {
    std::uint32_t triangle = none;
    std::uint32_t surface = none;
    double distance = std::numeric_limits<double>::infinity();
    bool exact = false;
};

/// Travels with one query through Embree to the filter.
struct QueryContext {
    RTCIntersectContext embree;
    const EmbreeQuery* query;
    const Ray* ray;
    Candidate best;
    double least_distance;
    double shift;  ///< Embree's ray starts this far behind the origin
};

class Bare final : public RayQuery::BareScene {
public:
    Bare(EmbreeScene scene) : scene_(std::move(scene)) {}
    std::uint64_t intersect_all(const std::vector<RayQuery::BareRay>& rays) const override {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        std::uint64_t sum = 0;
        RTCRayHit hit{};
        for (const RayQuery::BareRay& ray : rays) {
            hit.ray = {ray.origin.x,
                       ray.origin.y,
                       ray.origin.z,
                       ray.near,
                       ray.direction.x,
                       ray.direction.y,
                       ray.direction.z,
                       0,
                       std::numeric_limits<float>::infinity(),
                       ~0u,
                       0,
                       0};
            hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
            hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
            rtcIntersect1(scene_.get(), &context, &hit);
            sum += hit.hit.primID;
        }
        return sum;
    }

private:
    EmbreeScene scene_;
};

class EmbreeQuery final : public RayQuery {
public:
    static Result<std::unique_ptr<RayQuery>> make(const Scene& scene, const std::string& isa);

    RayAnswer nearest(const Ray& ray) const override;
    const std::vector<TriangleRecord>& triangles() const override { return records_; }
    double near_edge_m() const override { return near_edge * half_extent_; }
    std::string isa() const override { return isa_; }
    std::unique_ptr<BareScene> bare_scene(const Scene& scene) const override;

private:
    static void filter(const RTCFilterFunctionNArguments* arguments);
    static void filter_avx2(const RTCFilterFunctionNArguments* arguments);
    static void filter_baseline(const RTCFilterFunctionNArguments* arguments);
    /// Decides about one candidate; true when it becomes the best.
    bool consider(QueryContext& context, const RTCHit& hit, const RTCRay& ray) const;
    Candidate examine(const QueryContext& context, std::uint32_t triangle, std::uint32_t surface) const;
    bool certainly_inside(const RTCHit& hit, const RTCRay& ray) const;
    bool replace_if_nearer(QueryContext& context, Candidate candidate) const;

    void fill_records(const Scene& scene);
    void add_surface(const Scene& scene, std::uint32_t surface);
    Result<void> open(const std::string& isa);

    const RTCFilterFunctionN filter_ = has_wide_registers() ? filter_avx2 : filter_baseline;
    Device device_;
    EmbreeScene scene_;
    std::vector<TriangleRecord> records_;
    std::vector<std::uint32_t> first_triangle_;  ///< by surface, which is Embree's geometry
    /// By surface: (enlargement + certain_inside) * longest enlarged edge; over twice the area it is the barycentric
    /// margin that a certain meeting keeps from every edge. Infinite for a surface with slivers: all is decided in
    /// double.
    std::vector<float> margin_;
    Vec3d centre_;
    double half_extent_ = 1;
    float window_ = 0;
    std::string isa_;
};

void EmbreeQuery::fill_records(const Scene& scene) {
    const Box box = bounding_box(scene);
    centre_ = (box.low + box.high) * 0.5;
    half_extent_ = std::max({box.high.x - box.low.x, box.high.y - box.low.y, box.high.z - box.low.z}) / 2;
    window_ = static_cast<float>(distance_window * half_extent_);
    records_.reserve(scene.triangles.size());
    prefer_huge_pages(records_.data(), scene.triangles.size() * sizeof(TriangleRecord));
    records_.resize(scene.triangles.size());
    for (std::uint32_t s = 0; s < scene.surfaces.size(); ++s) {
        const Surface& surface = scene.surfaces[s];
        for (std::uint32_t t = surface.first_triangle; t < surface.first_triangle + surface.triangle_count; ++t) {
            TriangleRecord& record = records_[t];
            for (std::size_t k = 0; k < 3; ++k) record.corners[k] = scene.positions[scene.triangles[t][k]];
            record.normal = normalize(triangle_cross(scene, t));
            record.surface = s;
        }
    }
}

void EmbreeQuery::add_surface(const Scene& scene, std::uint32_t s) {
    const Surface& surface = scene.surfaces[s];
    const std::size_t count = surface.triangle_count;
    RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<Vec3f*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3f), 3 * count));
    auto* indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), count));
    double longest = 0;
    if (vertices && indices) {
        for (std::uint32_t t = 0; t < count; ++t) {
            std::array<Vec3d, 3> corners;
            for (std::size_t k = 0; k < 3; ++k)
                corners[k] = records_[surface.first_triangle + t].corners[k].as<double>() - centre_;
            const auto large = enlarged(corners, enlargement * half_extent_);
            for (std::uint32_t k = 0; k < 3; ++k) {
                vertices[3 * t + k] = large.corners[k].as<float>();
                indices[3 * t + k] = 3 * t + k;
                longest = std::max(longest, length(large.corners[k] - large.corners[(k + 1) % 3]));
            }
            if (!large.parallel) longest = std::numeric_limits<double>::infinity();
        }
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(scene_.get(), geometry, s);
    }
    rtcReleaseGeometry(geometry);
    first_triangle_.push_back(surface.first_triangle);
    margin_.push_back(static_cast<float>((enlargement + certain_inside) * half_extent_ * longest));
}

Result<void> EmbreeQuery::open(const std::string& isa) {
    // Embree's own threads build the hierarchy; tracing threads are the caller's
    const std::string configuration = isa.empty() ? "" : "isa=" + isa;
    device_.reset(rtcNewDevice(configuration.c_str()));
    if (!device_ || rtcGetDeviceError(device_.get()) != RTC_ERROR_NONE)
        return bad_input("Embree does not start with the instruction set '" + isa + "' on this machine");
    const auto has = [&](RTCDeviceProperty property) { return rtcGetDeviceProperty(device_.get(), property) != 0; };
    isa_ = !isa.empty()                                      ? isa
           : has(RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) ? "avx512"
           : has(RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED)  ? "avx2"
                                                             : "sse4.2";
    return {};
}

Result<std::unique_ptr<RayQuery>> EmbreeQuery::make(const Scene& scene, const std::string& isa) {
    auto query = std::make_unique<EmbreeQuery>();
    if (auto opened = query->open(isa); !opened) return opened.error();
    query->fill_records(scene);
    query->scene_.reset(rtcNewScene(query->device_.get()));
    rtcSetSceneBuildQuality(query->scene_.get(), RTC_BUILD_QUALITY_MEDIUM);
    rtcSetSceneFlags(query->scene_.get(), RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
    for (std::uint32_t s = 0; s < scene.surfaces.size(); ++s) query->add_surface(scene, s);
    rtcCommitScene(query->scene_.get());
    if (const RTCError error = rtcGetDeviceError(query->device_.get()); error != RTC_ERROR_NONE)
        return failed("Embree could not build its hierarchy of " + std::to_string(scene.triangles.size()) +
                      " triangles (error " + std::to_string(error) +
                      (error == RTC_ERROR_OUT_OF_MEMORY ? ", out of memory)" : ")"));
    return std::unique_ptr<RayQuery>(std::move(query));
}

bool EmbreeQuery::certainly_inside(const RTCHit& hit, const RTCRay& ray) const {
    const float area2 = hit.Ng_x * hit.Ng_x + hit.Ng_y * hit.Ng_y + hit.Ng_z * hit.Ng_z;
    const float approach = hit.Ng_x * ray.dir_x + hit.Ng_y * ray.dir_y + hit.Ng_z * ray.dir_z;
    if (approach * approach < certain_cosine * certain_cosine * area2) return false;
    // barycentric weight * (twice the area / longest edge) is at most the distance from the edge
    const float least = std::min({hit.u, hit.v, 1 - hit.u - hit.v});
    const float margin = margin_[hit.geomID];
    return least > 0 && least * least * area2 > margin * margin;
}

Candidate EmbreeQuery::examine(const QueryContext& context, std::uint32_t triangle, std::uint32_t surface) const {
    const TriangleMeeting meeting = meet_triangle(records_[triangle], context.ray->origin, context.ray->direction);
    if (!meeting.meets || meeting.distance <= context.least_distance) return {};
    return {triangle, surface, meeting.distance, true};
}

bool EmbreeQuery::replace_if_nearer(QueryContext& context, Candidate candidate) const {
    Candidate& best = context.best;
    const double window = distance_window * half_extent_;
    if (best.triangle == none || candidate.distance < best.distance - window) {
        best = candidate;
        return true;
    }
    if (candidate.distance > best.distance + window) return false;
    // too close for float: both in double, ties to the lowest number
    if (!best.exact) best = examine(context, best.triangle, best.surface);
    if (!candidate.exact) candidate = examine(context, candidate.triangle, candidate.surface);
    if (candidate.triangle == none) return false;
    const bool nearer = candidate.distance < best.distance ||
                        (candidate.distance == best.distance && candidate.triangle < best.triangle);
    if (best.triangle != none && !nearer) return false;
    best = candidate;
    return true;
}

bool EmbreeQuery::consider(QueryContext& context, const RTCHit& hit, const RTCRay& ray) const {
    const std::uint32_t triangle = first_triangle_[hit.geomID] + hit.primID;
    if (triangle == context.ray->from_triangle) return false;
    const double distance = static_cast<double>(ray.tfar) - context.shift;
    const bool near = distance < context.least_distance + 2 * distance_window * half_extent_;
    Candidate candidate{triangle, hit.geomID, distance, false};
    if (near || !certainly_inside(hit, ray)) candidate = examine(context, triangle, hit.geomID);
    return candidate.triangle != none && replace_if_nearer(context, candidate);
}

// The same arithmetic in the encoding that Embree's own code uses, which is cheaper to call from there.
[[gnu::target("avx2,bmi,bmi2"), gnu::flatten]] void EmbreeQuery::filter_avx2(
    const RTCFilterFunctionNArguments* arguments) {
    filter(arguments);
}

[[gnu::flatten]] void EmbreeQuery::filter_baseline(const RTCFilterFunctionNArguments* arguments) { filter(arguments); }

inline void EmbreeQuery::filter(const RTCFilterFunctionNArguments* arguments) {
    auto& context = *reinterpret_cast<QueryContext*>(arguments->context);
    auto& ray = *reinterpret_cast<RTCRay*>(arguments->ray);
    const auto& hit = *reinterpret_cast<const RTCHit*>(arguments->hit);
    if (!context.query->consider(context, hit, ray)) {
        arguments->valid[0] = 0;
        return;
    }
    // Embree goes on with everything that may be as near as this in double
    ray.tfar = static_cast<float>(context.best.distance + context.shift) + context.query->window_;
}

RayAnswer EmbreeQuery::nearest(const Ray& ray) const {
    QueryContext context;
    rtcInitIntersectContext(&context.embree);
    context.embree.filter = filter_;
    context.query = this;
    context.ray = &ray;
    // Near an edge Embree's ray starts behind the origin, so that a wall that begins right there is not missed.
    // Elsewhere nothing but the triangle itself is near.
    const bool careful = ray.near_edge;
    context.least_distance = (careful ? origin_window : near_distance) * half_extent_;
    context.shift = careful ? near_distance * half_extent_ : 0;
    const Vec3f origin = (ray.origin - centre_ - ray.direction * context.shift).as<float>();
    const Vec3f direction = ray.direction.as<float>();
    RTCRayHit hit;
    hit.ray = {origin.x,
               origin.y,
               origin.z,
               careful ? 0 : static_cast<float>(near_distance / 2 * half_extent_),
               direction.x,
               direction.y,
               direction.z,
               0,
               std::numeric_limits<float>::infinity(),
               ~0u,
               0,
               0};
    hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_.get(), &context.embree, &hit);
    return {context.best.triangle, context.best.surface};
}

std::unique_ptr<RayQuery::BareScene> EmbreeQuery::bare_scene(const Scene& scene) const {
    EmbreeScene bare(rtcNewScene(device_.get()));
    rtcSetSceneBuildQuality(bare.get(), RTC_BUILD_QUALITY_MEDIUM);
    RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<Vec3f*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                                 sizeof(Vec3f), scene.positions.size()));
    auto* indices = static_cast<Triangle*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                                   sizeof(Triangle), scene.triangles.size()));
    ensure(vertices && indices, "Embree has memory for the bare scene");
    std::copy(scene.positions.begin(), scene.positions.end(), vertices);
    std::copy(scene.triangles.begin(), scene.triangles.end(), indices);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(bare.get(), geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(bare.get());
    return std::make_unique<Bare>(std::move(bare));
}

}  // namespace

Result<std::unique_ptr<RayQuery>> RayQuery::make(const Scene& scene, const std::string& isa) {
    return EmbreeQuery::make(scene, isa);
}

}  // namespace lumenfarm
