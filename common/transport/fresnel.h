#pragma once

#include <cmath>

/// A smooth boundary between two transparent media.
namespace lumenfarm {

/// Unpolarised reflectance and the cosine of the refracted ray [Born and Wolf, 1.5.2].
struct FresnelSplit {
    double reflectance;      ///< 1 at total internal reflection
    double cos_transmitted;  ///< 0 at total internal reflection
};

/// `cos_incident` in (0, 1]; `relative_index` is n of the far side over n of the near side.
inline FresnelSplit fresnel(double cos_incident, double relative_index) {
    const double sine2 = (1 - cos_incident * cos_incident) / (relative_index * relative_index);
    if (sine2 >= 1) return {1, 0};
    const double cos_transmitted = std::sqrt(1 - sine2);
    const double parallel =
        (relative_index * cos_incident - cos_transmitted) / (relative_index * cos_incident + cos_transmitted);
    const double perpendicular =
        (cos_incident - relative_index * cos_transmitted) / (cos_incident + relative_index * cos_transmitted);
    return {(parallel * parallel + perpendicular * perpendicular) / 2, cos_transmitted};
}

/// All orders of reflection in a sheet with parallel faces and no absorption: R = 2 r / (1 + r).
inline double sheet_reflectance(double reflectance) { return 2 * reflectance / (1 + reflectance); }

}  // namespace lumenfarm
