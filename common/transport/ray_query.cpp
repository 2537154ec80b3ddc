#include "common/transport/ray_query.h"

#include "common/support/ensure.h"
#include "common/support/huge_pages.h"
#include "common/transport/clearance.h"
#include "common/transport/enlarged_triangle.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

namespace lumenfarm {
namespace {

// Lengths as fractions of the scene's half extent S. Embree computes in float (2^-24). Across the ray its error is
// around 2^-24 S; over a million rays it was 2^-20.5 S at most. Along the ray it grows as 1 / cos of the angle of
// incidence.
constexpr double enlargement = 0x1p-18;     ///< by which each edge of Embree's triangles is moved outwards
constexpr double near_reach = 0x1p-18;      ///< what counts as near another triangle
constexpr double edge_band = 0x1p-17;       ///< what counts as near an edge
constexpr double clear_distance = 0x1p-19;  ///< Embree ignores what a ray with a clear start meets before
constexpr double careful_window = 0x1p-8;   ///< around a meeting, along the ray, in which all others are compared
constexpr double origin_window = 1e-12;     ///< meetings closer than this are the origin itself
constexpr double endless = std::numeric_limits<double>::infinity();
static_assert(edge_band >= near_reach);

struct DeviceRelease {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct SceneRelease {
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
using Device = std::unique_ptr<std::remove_pointer_t<RTCDevice>, DeviceRelease>;
using EmbreeScene = std::unique_ptr<std::remove_pointer_t<RTCScene>, SceneRelease>;

class EmbreeQuery;

/// Travels with one careful query through Embree to the filter.
struct CarefulContext {
    RTCIntersectContext embree;
    const EmbreeQuery* query;
    const Ray* ray;
    std::uint32_t triangle = none;  ///< the nearest meeting so far
    double distance = std::numeric_limits<double>::infinity();
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
    static Result<std::unique_ptr<RayQuery>> make(const Scene& scene, const SceneExtent& extent,
                                                  const std::string& isa);

    std::uint32_t nearest(const Ray& ray) const override { return nearest(ray, 0, endless); }
    void nearest(const RayLanes& rays, std::size_t count, MeetingLanes& meetings) const override {
        find(rays, Anywhere{}, count, meetings);
    }
    void nearest(const RayLanes& rays, const WindowLanes& windows, std::size_t count,
                 MeetingLanes& meetings) const override {
        find(rays, windows, count, meetings);
    }
    SceneExtent extent() const override { return extent_; }
    const ClearanceMap& clearance() const override { return clearance_; }
    const std::vector<TriangleRecord>& triangles() const override { return records_; }
    std::string isa() const override { return isa_; }
    std::unique_ptr<BareScene> bare_scene(const Scene& scene) const override;

private:
    static constexpr std::size_t packet_lanes = 8;

    static void filter(const RTCFilterFunctionNArguments* arguments);
    /// Compares a candidate in double; true when it is the nearest so far.
    bool improve(CarefulContext& context, std::uint32_t triangle) const;

    /// For rays that are asked all along: what WindowLanes is for the others.
    struct Anywhere {};
    template <class Windows>
    void find(const RayLanes& rays, const Windows& windows, std::size_t count, MeetingLanes& meetings) const;
    std::uint32_t nearest(const Ray& ray, double enters, double leaves) const;
    void fill_packet(const RayLanes& rays, std::size_t first, RTCRayHit8& packet) const;
    void fill_windows(const WindowLanes& windows, std::size_t first, RTCRayHit8& packet) const;
    /// Embree's answer for a ray with a clear start needs no second look.
    bool is_certain(const RTCRayHit8& packet, std::size_t k, std::uint32_t triangle, std::uint32_t from) const;
    void ask_again(const Ray& ray, double enters, double leaves, std::size_t lane, MeetingLanes& meetings) const;

    void fill_records(const Scene& scene);
    void add_surface(const Scene& scene, std::uint32_t surface);
    Result<void> open(const std::string& isa);

    Device device_;
    EmbreeScene scene_;
    std::vector<TriangleRecord> records_;
    std::vector<std::uint32_t> first_triangle_;  ///< by surface, which is Embree's geometry
    ClearanceMap clearance_;
    SceneExtent extent_;
    std::string isa_;
};

void EmbreeQuery::fill_records(const Scene& scene) {
    clearance_ = ClearanceMap::make(
        scene, {near_reach * extent_.half_m, edge_band * extent_.half_m, enlargement * extent_.half_m});
    records_.reserve(scene.triangles.size());
    prefer_huge_pages(records_.data(), scene.triangles.size() * sizeof(TriangleRecord));
    records_.resize(std::max<std::size_t>(1, scene.triangles.size()));  // lanes without a triangle read the first
    for (std::uint32_t s = 0; s < scene.surfaces.size(); ++s) {
        const Surface& surface = scene.surfaces[s];
        for (std::uint32_t t = surface.first_triangle; t < surface.first_triangle + surface.triangle_count; ++t) {
            TriangleRecord& record = records_[t];
            record = triangle_record(scene, t, s);
            const auto corner = [&](std::size_t k) { return record.corners[k].as<double>(); };
            record.clearance = clearance_.triangles()[t];
            record.embree_first = static_cast<std::uint32_t>(blunt_corner({corner(0), corner(1), corner(2)}));
        }
    }
}

void EmbreeQuery::add_surface(const Scene& scene, std::uint32_t s) {
    const Surface& surface = scene.surfaces[s];
    const std::size_t count = surface.triangle_count;
    first_triangle_.push_back(surface.first_triangle);
    if (count == 0) return;
    RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<Vec3f*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3f), 3 * count));
    auto* indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), count));
    if (vertices && indices) {
        for (std::uint32_t t = 0; t < count; ++t) {
            Corners corners;
            const TriangleRecord& record = records_[surface.first_triangle + t];
            for (std::size_t k = 0; k < 3; ++k)
                corners[k] = record.corners[(record.embree_first + k) % 3].as<double>() - extent_.centre;
            const auto large = enlarged(corners, enlargement * extent_.half_m);
            for (std::uint32_t k = 0; k < 3; ++k) {
                vertices[3 * t + k] = large.corners[k].as<float>();
                indices[3 * t + k] = 3 * t + k;
            }
        }
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(scene_.get(), geometry, s);
    }
    rtcReleaseGeometry(geometry);
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
           : has(RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED)  ? (__builtin_cpu_supports("avx2") ? "avx2" : "avx")
                                                             : "sse4.2";
    return {};
}

Result<std::unique_ptr<RayQuery>> EmbreeQuery::make(const Scene& scene, const SceneExtent& extent,
                                                    const std::string& isa) {
    auto query = std::make_unique<EmbreeQuery>();
    query->extent_ = extent;
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

bool EmbreeQuery::improve(CarefulContext& context, std::uint32_t triangle) const {
    if (triangle == context.ray->from_triangle) return false;
    const TriangleMeeting meeting = meet_triangle(records_[triangle], context.ray->origin, context.ray->direction);
    if (!meeting.meets || meeting.distance <= origin_window * extent_.half_m) return false;
    if (meeting.distance > context.distance) return false;
    if (meeting.distance == context.distance && triangle > context.triangle) return false;
    context.triangle = triangle;
    context.distance = meeting.distance;
    return true;
}

void EmbreeQuery::filter(const RTCFilterFunctionNArguments* arguments) {
    auto& context = *reinterpret_cast<CarefulContext*>(arguments->context);
    const auto& hit = *reinterpret_cast<const RTCHit*>(arguments->hit);
    const EmbreeQuery& query = *context.query;
    if (!query.improve(context, query.first_triangle_[hit.geomID] + hit.primID)) {
        arguments->valid[0] = 0;
        return;
    }
    // Embree goes on with everything that may be as near as this; its ray starts a window behind the origin
    auto& ray = *reinterpret_cast<RTCRay*>(arguments->ray);
    ray.tfar = static_cast<float>(context.distance + 2 * careful_window * query.extent_.half_m);
}

std::uint32_t EmbreeQuery::nearest(const Ray& ray, double enters, double leaves) const {
    const Ray near{extent_.approached(ray.origin, ray.direction), ray.direction, ray.from_triangle};
    CarefulContext context;
    rtcInitIntersectContext(&context.embree);
    context.embree.filter = filter;
    context.query = this;
    context.ray = &near;
    // Embree's ray starts a window behind the origin, so that all along it has a window before and behind
    const double window = careful_window * extent_.half_m;
    const Vec3f origin = (near.origin - extent_.centre - ray.direction * window).as<float>();
    const Vec3f direction = ray.direction.as<float>();
    RTCRayHit hit;
    hit.ray = {origin.x,
               origin.y,
               origin.z,
               static_cast<float>(enters),
               direction.x,
               direction.y,
               direction.z,
               0,
               static_cast<float>(leaves + 2 * window),
               ~0u,
               0,
               0};
    hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_.get(), &context.embree, &hit);
    return context.triangle;
}

void EmbreeQuery::fill_packet(const RayLanes& rays, std::size_t first, RTCRayHit8& packet) const {
    const auto near = static_cast<float>(clear_distance * extent_.half_m);
    for (std::size_t k = 0; k < packet_lanes; ++k) {
        packet.ray.org_x[k] = static_cast<float>(rays.origin.x[first + k] - extent_.centre.x);
        packet.ray.org_y[k] = static_cast<float>(rays.origin.y[first + k] - extent_.centre.y);
        packet.ray.org_z[k] = static_cast<float>(rays.origin.z[first + k] - extent_.centre.z);
        packet.ray.dir_x[k] = static_cast<float>(rays.direction.x[first + k]);
        packet.ray.dir_y[k] = static_cast<float>(rays.direction.y[first + k]);
        packet.ray.dir_z[k] = static_cast<float>(rays.direction.z[first + k]);
        packet.ray.tnear[k] = near;
        packet.ray.time[k] = 0;
        packet.ray.tfar[k] = std::numeric_limits<float>::infinity();
        packet.ray.mask[k] = ~0u;
        packet.ray.id[k] = 0;
        packet.ray.flags[k] = 0;
        packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
        packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
    }
}

bool EmbreeQuery::is_certain(const RTCRayHit8& packet, std::size_t k, std::uint32_t triangle,
                             std::uint32_t from) const {
    const Vec3f normal{packet.hit.Ng_x[k], packet.hit.Ng_y[k], packet.hit.Ng_z[k]};
    const Vec3f direction{packet.ray.dir_x[k], packet.ray.dir_y[k], packet.ray.dir_z[k]};
    const float approach = dot(normal, direction);
    constexpr auto steep = static_cast<float>(steep_cosine);
    // Embree's weights, from its order of corners to ours
    const std::array<float, 3> weights{1 - packet.hit.u[k] - packet.hit.v[k], packet.hit.u[k], packet.hit.v[k]};
    const TriangleRecord& record = records_[triangle];
    const float b1 = weights[(4 - record.embree_first) % 3];
    const float b2 = weights[(5 - record.embree_first) % 3];
    return triangle != from && approach * approach >= steep * steep * dot(normal, normal) &&
           clearance_.is_clear(record.clearance, b1, b2);
}

void EmbreeQuery::ask_again(const Ray& ray, double enters, double leaves, std::size_t lane,
                            MeetingLanes& meetings) const {
    const std::uint32_t triangle = nearest(ray, enters, leaves);
    meetings.triangle[lane] = triangle;
    meetings.clear[lane] = false;
    if (triangle == none) return;
    const TriangleMeeting meeting = meet_triangle(records_[triangle], ray.origin, ray.direction);
    meetings.clear[lane] = clearance_.is_clear(records_[triangle].clearance, meeting.b1, meeting.b2);
}

void EmbreeQuery::fill_windows(const WindowLanes& windows, std::size_t first, RTCRayHit8& packet) const {
    const double window = careful_window * extent_.half_m;
    for (std::size_t k = 0; k < packet_lanes; ++k) {
        packet.ray.tnear[k] = std::max(packet.ray.tnear[k], static_cast<float>(windows.enters[first + k] - window));
        packet.ray.tfar[k] = static_cast<float>(windows.leaves[first + k] + window);
    }
}

template <class Windows>
void EmbreeQuery::find(const RayLanes& rays, const Windows& windows, std::size_t count, MeetingLanes& meetings) const {
    constexpr bool windowed = std::is_same_v<Windows, WindowLanes>;
    const auto starts_clear = [&](std::size_t lane) {
        if constexpr (windowed)
            if (windows.enters[lane] > 2 * careful_window * extent_.half_m)
                return true;  // what is at the start is behind
        return rays.clear_start[lane] != 0;
    };
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    std::array<RTCRayHit8, lane_count / packet_lanes> packets;
    for (std::size_t first = 0; first < count; first += packet_lanes) {
        RTCRayHit8& packet = packets[first / packet_lanes];
        fill_packet(rays, first, packet);
        if constexpr (windowed) fill_windows(windows, first, packet);
        alignas(32) std::array<int, packet_lanes> valid;
        for (std::size_t k = 0; k < packet_lanes; ++k) valid[k] = first + k < count && starts_clear(first + k) ? -1 : 0;
        rtcIntersect8(valid.data(), scene_.get(), &context, &packet);
        for (std::size_t k = 0; k < packet_lanes; ++k) {
            const std::uint32_t surface = packet.hit.geomID[k];
            std::uint32_t& triangle = meetings.triangle[first + k];
            triangle = surface == RTC_INVALID_GEOMETRY_ID ? none : first_triangle_[surface] + packet.hit.primID[k];
            if (triangle != none) __builtin_prefetch(&records_[triangle]);
        }
    }
    for (std::size_t lane = 0; lane < count; ++lane) {
        std::uint32_t& triangle = meetings.triangle[lane];
        meetings.clear[lane] = true;
        const bool certain =
            starts_clear(lane) && (triangle == none || is_certain(packets[lane / packet_lanes], lane % packet_lanes,
                                                                  triangle, rays.from_triangle[lane]));
        if constexpr (windowed) {
            if (!certain) ask_again(rays.at(lane), windows.enters[lane], windows.leaves[lane], lane, meetings);
            if (triangle != none && meeting_distance(records_[triangle], rays.origin.at(lane),
                                                     rays.direction.at(lane)) >= windows.leaves[lane])
                triangle = none;
        } else {
            if (!certain) ask_again(rays.at(lane), 0, endless, lane, meetings);
        }
    }
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

SceneExtent scene_extent(const Scene& scene) {
    const Box box = bounding_box(scene);
    return {(box.low + box.high) * 0.5,
            std::max({box.high.x - box.low.x, box.high.y - box.low.y, box.high.z - box.low.z}) / 2};
}

Result<std::unique_ptr<RayQuery>> RayQuery::make(const Scene& scene, const SceneExtent& extent,
                                                 const std::string& isa) {
    return EmbreeQuery::make(scene, extent, isa);
}

}  // namespace lumenfarm
