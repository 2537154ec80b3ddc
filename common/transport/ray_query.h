#pragma once

#include "common/scene/scene.h"
#include "common/support/result.h"
#include "common/transport/triangle_test.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

/// Nearest meeting of a ray with the scene. Embree finds the candidates over slightly enlarged triangles; every
/// doubtful one is decided by triangle_test.h, so that the answer does not depend on Embree's instruction set
/// (docs/physics.md).
namespace lumenfarm {

struct Ray {
    Vec3d origin;
    Vec3d direction;                     ///< unit
    std::uint32_t from_triangle = none;  ///< that the origin lies on; it is not met again
    bool near_edge = false;  ///< the origin lies so near an edge that another triangle may be closer than near_m()
};

/// A candidate or the final answer.
struct RayAnswer {
    std::uint32_t triangle = none;
    std::uint32_t surface = none;
};

class RayQuery {
public:
    /// Errors: failed (Embree's sentence). `isa` as in TracerScene::make.
    static Result<std::unique_ptr<RayQuery>> make(const Scene& scene, const std::string& isa);
    virtual ~RayQuery() = default;

    /// The triangle of the nearest meeting at a distance > 0; ties go to the lowest number.
    virtual RayAnswer nearest(const Ray& ray) const = 0;
    virtual const std::vector<TriangleRecord>& triangles() const = 0;
    /// Rays that start closer than this to an edge of their triangle set near_edge [m].
    virtual double near_edge_m() const = 0;
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
