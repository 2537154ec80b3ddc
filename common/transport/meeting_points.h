#pragma once

#include "common/transport/hit.h"
#include "common/transport/ray_query.h"
#include "common/transport/triangle_lanes.h"

#include <cmath>
#include <cstdint>

/// Where rays meet their triangles, in double, and what a hit record keeps of it.
namespace lumenfarm {

/// floor(b * 65536), kept within 16 bits.
inline std::int32_t packed_weight(double b) {
    const double scaled = b * 65536;
    return static_cast<std::int32_t>(scaled < 65535 ? (scaled > 0 ? scaled : 0) : 65535);
}

struct MeetingPoints {
    VecLanes position;             ///< on the triangle by its barycentric weights, however far the ray came
    VecLanes normal;               ///< unit, on the side of incidence
    Lanes<double> cos_incident{};  ///< -direction . normal
    Lanes<double> b1{}, b2{};
    Lanes<std::int32_t> packed_b1{}, packed_b2{};
    Lanes<std::int32_t> direction_u{}, direction_v{};  ///< octahedral
    Lanes<std::int32_t> back{};

    std::uint32_t surface(std::size_t lane) const { return triangles_.surface(lane); }

    /// Lanes that meet nothing hold numbers without meaning.
    void find(const TriangleRecord* triangles, const RayLanes& rays, const MeetingLanes& meetings);

private:
    TriangleLanes triangles_;
};

inline void MeetingPoints::find(const TriangleRecord* triangles, const RayLanes& rays, const MeetingLanes& meetings) {
    triangles_.gather(triangles, meetings.triangle);
    for (std::size_t k = 0; k < lane_count; ++k) {
        // [Moller and Trumbore 1997], with the determinant from the normal, which is needed anyway
        const Vec3d direction = rays.direction.at(k);
        const Vec3d corner = triangles_.corner(k, 0);
        const Vec3d edge1 = triangles_.corner(k, 1) - corner;
        const Vec3d edge2 = triangles_.corner(k, 2) - corner;
        const Vec3d across = cross(edge1, edge2);
        const double approach = dot(across, direction);
        const Vec3d from = rays.origin.at(k) - corner;
        const Vec3d turned = cross(direction, from);
        const double scale = 1 / approach;
        b1[k] = dot(edge2, turned) * scale;
        b2[k] = dot(edge1, turned) * -scale;
        position.set(k, corner + edge1 * b1[k] + edge2 * b2[k]);
        const double unit = triangles_.per_double_area_m2(k);
        back[k] = approach > 0;
        normal.set(k, across * (approach > 0 ? -unit : unit));
        cos_incident[k] = std::abs(approach) * unit;
        packed_b1[k] = packed_weight(b1[k]);
        packed_b2[k] = packed_weight(b2[k]);
        const OctahedralDirection packed = encode_direction(direction.as<float>());
        direction_u[k] = packed.u;
        direction_v[k] = packed.v;
    }
}

}  // namespace lumenfarm
