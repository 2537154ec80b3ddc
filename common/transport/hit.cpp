#include "common/transport/hit.h"

#include <cmath>

namespace lumenfarm {
namespace {

std::uint16_t quantize(double value) {
    const double scaled = (value + 1) * 32767.5 + 0.5;
    return static_cast<std::uint16_t>(scaled < 65535 ? (scaled > 0 ? scaled : 0) : 65535);
}
double dequantize(std::uint16_t value) { return value / 32767.5 - 1; }
double sign_of(double x) { return x < 0 ? -1.0 : 1.0; }

}  // namespace

OctahedralDirection encode_direction(Vec3d unit) {
    const double scale = 1 / (std::abs(unit.x) + std::abs(unit.y) + std::abs(unit.z));
    double u = unit.x * scale;
    double v = unit.y * scale;
    if (unit.z < 0) {
        const double folded = (1 - std::abs(v)) * sign_of(u);
        v = (1 - std::abs(u)) * sign_of(v);
        u = folded;
    }
    return {quantize(u), quantize(v)};
}

Vec3d decode_direction(OctahedralDirection packed) {
    double u = dequantize(packed.u);
    double v = dequantize(packed.v);
    const double z = 1 - std::abs(u) - std::abs(v);
    if (z < 0) {
        const double folded = (1 - std::abs(v)) * sign_of(u);
        v = (1 - std::abs(u)) * sign_of(v);
        u = folded;
    }
    return normalize(Vec3d{u, v, z});
}

}  // namespace lumenfarm
