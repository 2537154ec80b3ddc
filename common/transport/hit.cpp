#include "common/transport/hit.h"

#include <cmath>

namespace lumenfarm {
namespace {

double dequantize(std::uint16_t value) { return value / 32767.5 - 1; }
double sign_of(double x) { return x < 0 ? -1.0 : 1.0; }

}  // namespace

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
