#pragma once

#include "common/scene/scene.h"
#include "common/support/result.h"
#include "common/transport/lanes.h"
#include "common/transport/triangle_test.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

/// Nearest meetings of rays with the scene: of all meetings in double (triangle_test.h), but those at the very origin
/// and with the triangle that the ray starts on, the nearest, ties to the lowest number. Embree finds it; where its
/// float arithmetic leaves doubt, double decides, so that the answer does not depend on Embree's instruction set
/// (docs/physics.md).
namespace lumenfarm {

struct Ray {
    Vec3d origin;
    Vec3d direction;                     ///< unit
    std::uint32_t from_triangle = none;  ///< that the origin lies on; it is not met again
};

struct RayLanes {
    VecLanes origin;
    VecLanes direction;
    Lanes<std::uint32_t> from_triangle{};
    /// Not 0: no other triangle is near the origin (Clearance) and the ray leaves its own triangle at a cosine of at
    /// least RayQuery::steep_cosine. Such rays are answered sooner; the answer is the same.
    Lanes<std::uint32_t> clear_start{};

    Ray at(std::size_t lane) const { return {origin.at(lane), direction.at(lane), from_triangle[lane]}; }
};

struct MeetingLanes {
    Lanes<std::uint32_t> triangle{};  ///< none: nothing is met
    Lanes<std::uint32_t> clear{};     ///< not 0: no other triangle is near the meeting (Clearance)
};

/// Where along each ray a meeting counts: at distances in [enters, leaves). REQUIRES: enters >= 0, and nothing is met
/// before it.
struct WindowLanes {
    Lanes<double> enters{}, leaves{};
};

/// The cube about the scene in which rays are asked for.
struct SceneExtent {
    Vec3d centre;
    double half_m = 1;
    bool operator==(const SceneExtent&) const = default;

    /// An origin far from the scene moves along its unit direction to where the scene may begin; others stay. Embree
    /// works in float, which holds the scene's numbers, not those of a lamp far away.
    Vec3d approached(Vec3d origin, Vec3d direction) const {
        const double skipped = dot(centre - origin, direction) - 2 * half_m;  // the cube ends sqrt(3) half_m from it
        return skipped > 0 ? origin + direction * skipped : origin;
    }
};

SceneExtent scene_extent(const Scene& scene);

class RayQuery {
public:
    static constexpr double steep_cosine = 1.0 / 16;

    /// `extent`: of the whole scene, of which `scene` may be a part. Errors: failed (Embree's sentence). `isa` as in
    /// TracerScene::make.
    static Result<std::unique_ptr<RayQuery>> make(const Scene& scene, const SceneExtent& extent,
                                                  const std::string& isa);
    virtual ~RayQuery() = default;

    /// The triangle that the ray meets, or none.
    virtual std::uint32_t nearest(const Ray& ray) const = 0;
    /// The same for the first `count` lanes. REQUIRES: origins are approached().
    virtual void nearest(const RayLanes& rays, std::size_t count, MeetingLanes& meetings) const = 0;
    /// The same, but what a ray meets outside its window is not met.
    virtual void nearest(const RayLanes& rays, const WindowLanes& windows, std::size_t count,
                         MeetingLanes& meetings) const = 0;
    virtual SceneExtent extent() const = 0;
    virtual const ClearanceMap& clearance() const = 0;
    virtual const std::vector<TriangleRecord>& triangles() const = 0;
    virtual std::string isa() const = 0;

    /// The bare rate of Embree over the same rays, for the benchmark: plain triangles, no filter. One call a ray.
    /// Returns the sum of primitive numbers so that nothing is optimised away.
    struct BareRay {
        Vec3f origin, direction;
        float near = 0;
    };
    class BareScene {
    public:
        virtual ~BareScene() = default;
        virtual std::uint64_t intersect_all(const std::vector<BareRay>& rays) const = 0;
    };
    virtual std::unique_ptr<BareScene> bare_scene(const Scene& scene) const = 0;
};

}  // namespace lumenfarm
