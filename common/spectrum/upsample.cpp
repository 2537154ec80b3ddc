#include "common/spectrum/upsample.h"

#include "common/spectrum/cie.h"
#include "common/support/ensure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace lumenfarm {
namespace {

using Matrix3 = std::array<Vec3d, 3>;  ///< three rows

/// p / sqrt(1 + p^2) is +-1 to the last bit of a double from here on, so that black and white are exact.
constexpr float extreme_c2 = 1e9f;
constexpr double step_centre = 0.5;      ///< of t; the solver's polynomial is in u = t - step_centre
constexpr double residual_goal = 1e-7;   ///< of linear sRGB
constexpr double residual_good = 1e-4;   ///< beyond it the way from grey is tried
constexpr double coefficient_max = 2e4;  ///< of the solver's polynomial: steeper ones are boxes to 5 nm already
constexpr int iterations_max = 60;
constexpr int grey_steps = 8;

double sigmoid(double p) { return 0.5 + p / (2 * std::sqrt(1 + p * p)); }

/// Linear sRGB of a tabulated reflectance s under D65 is sum_i s_i weight[i]; white is (1, 1, 1) exactly.
std::array<Vec3d, spectrum_samples> make_colour_weights() {
    std::array<Vec3d, spectrum_samples> xyz{};
    for (std::uint32_t bin = 0; bin < wavelength_bins; ++bin) {
        const double light = value_at(illuminant_d65(), bin);
        const Vec3d colour = Vec3d{value_at(cie_x(), bin), value_at(cie_y(), bin), value_at(cie_z(), bin)} * light;
        const double fraction = (static_cast<double>(bin % bins_per_sample) + 0.5) / bins_per_sample;
        const std::size_t i = bin / bins_per_sample;
        xyz[i] = xyz[i] + colour * (1 - fraction);
        xyz[i + 1] = xyz[i + 1] + colour * fraction;
    }
    std::array<Vec3d, spectrum_samples> weights{};
    Vec3d white;
    for (std::size_t i = 0; i < spectrum_samples; ++i) {
        weights[i] = xyz_to_linear_srgb(xyz[i]);
        white = white + weights[i];
    }
    for (Vec3d& weight : weights) weight = {weight.x / white.x, weight.y / white.y, weight.z / white.z};
    return weights;
}

const std::array<Vec3d, spectrum_samples>& colour_weights() {
    static const std::array<Vec3d, spectrum_samples> weights = make_colour_weights();
    return weights;
}

/// The colour of the sigmoid of k0 u^2 + k1 u + k2 and its derivatives: column j of `jacobian` is d colour / d k_j.
struct Colour {
    Vec3d rgb;
    Matrix3 jacobian{};  ///< here three columns
};

Colour colour_of(Vec3d k) {
    Colour colour;
    const auto& weights = colour_weights();
    for (std::size_t i = 0; i < spectrum_samples; ++i) {
        const double u = static_cast<double>(i) / (spectrum_samples - 1) - step_centre;
        const double p = (k.x * u + k.y) * u + k.z;
        const double inverse = 1 / std::sqrt(1 + p * p);
        colour.rgb = colour.rgb + weights[i] * (0.5 + 0.5 * p * inverse);
        const Vec3d slope = weights[i] * (0.5 * inverse * inverse * inverse);
        colour.jacobian[0] = colour.jacobian[0] + slope * (u * u);
        colour.jacobian[1] = colour.jacobian[1] + slope * u;
        colour.jacobian[2] = colour.jacobian[2] + slope;
    }
    return colour;
}

/// Cramer's rule; nothing when the matrix is singular.
std::optional<Vec3d> solve(const Matrix3& rows, Vec3d right) {
    const Vec3d a{rows[0].x, rows[1].x, rows[2].x}, b{rows[0].y, rows[1].y, rows[2].y},
        c{rows[0].z, rows[1].z, rows[2].z};
    const double determinant = dot(a, cross(b, c));
    const Vec3d x{dot(right, cross(b, c)) / determinant, dot(a, cross(right, c)) / determinant,
                  dot(a, cross(b, right)) / determinant};
    if (!std::isfinite(x.x) || !std::isfinite(x.y) || !std::isfinite(x.z)) return std::nullopt;
    return x;
}

/// The damped normal equations (J^T J + damping diag(J^T J)) step = J^T residual [Marquardt 1963].
std::optional<Vec3d> damped_step(const Matrix3& jacobian, Vec3d residual, double damping) {
    Matrix3 normal;
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 3; ++column)
            normal[row][column] = dot(jacobian[row], jacobian[column]) * (row == column ? 1 + damping : 1);
    return solve(normal, {dot(jacobian[0], residual), dot(jacobian[1], residual), dot(jacobian[2], residual)});
}

struct Fit {
    Vec3d k;
    double residual = 0;
};

/// Gauss-Newton with damping from `start` towards the colour `rgb`.
Fit fit(Vec3d rgb, Vec3d start) {
    Vec3d k = start;
    Colour colour = colour_of(k);
    double residual = length(rgb - colour.rgb);
    double damping = 1e-3;
    for (int iteration = 0; iteration < iterations_max && residual > residual_goal && damping < 1e6; ++iteration) {
        const std::optional<Vec3d> step = damped_step(colour.jacobian, rgb - colour.rgb, damping);
        const Vec3d next = step ? k + *step : k;
        const bool inside = std::max({std::abs(next.x), std::abs(next.y), std::abs(next.z)}) < coefficient_max;
        if (step && inside) {
            const Colour there = colour_of(next);
            const double residual_there = length(rgb - there.rgb);
            if (residual_there < residual) {
                k = next, colour = there, residual = residual_there;
                damping *= 0.1;
                continue;
            }
        }
        damping = std::max(damping * 8, 1e-6);
    }
    return {k, residual};
}

/// p of a constant reflectance in (0, 1).
double constant_p(double reflectance) {
    const double q = 2 * reflectance - 1;
    return q / std::sqrt((1 - q) * (1 + q));
}

/// The way from grey: the target moves from the grey of equal mean to the colour in equal steps.
Fit fit_from_grey(Vec3d rgb, Vec3d grey, Vec3d start) {
    Fit best{start, length(rgb - grey)};
    for (int step = 1; step <= grey_steps; ++step) {
        const double fraction = static_cast<double>(step) / grey_steps;
        best = fit(grey + (rgb - grey) * fraction, best.k);
    }
    return best;
}

SigmoidCoefficients constant_coefficients(double reflectance) {
    if (reflectance <= 0) return {0, 0, -extreme_c2};
    if (reflectance >= 1) return {0, 0, extreme_c2};
    const auto c2 = static_cast<float>(std::clamp(constant_p(reflectance), -double{extreme_c2}, double{extreme_c2}));
    return {0, 0, c2};
}

bool is_grey(Vec3d rgb) { return rgb.x == rgb.y && rgb.y == rgb.z; }

Vec3d clamp_to_unit(Vec3d rgb) {
    return {std::clamp(rgb.x, 0.0, 1.0), std::clamp(rgb.y, 0.0, 1.0), std::clamp(rgb.z, 0.0, 1.0)};
}

}  // namespace

SigmoidCoefficients reflectance_coefficients(Vec3d rgb) {
    rgb = clamp_to_unit(rgb);
    if (is_grey(rgb)) return constant_coefficients(rgb.x);
    const double mean = (rgb.x + rgb.y + rgb.z) / 3;
    const Vec3d start{0, 0, constant_p(mean)};
    Fit best = fit(rgb, start);
    if (best.residual > residual_good) {
        const Fit other = fit_from_grey(rgb, {mean, mean, mean}, start);
        if (other.residual < best.residual) best = other;
    }
    // k0 (t - m)^2 + k1 (t - m) + k2 in powers of t
    const Vec3d k = best.k;
    return {static_cast<float>(k.x), static_cast<float>(k.y - 2 * step_centre * k.x),
            static_cast<float>(k.z - step_centre * k.y + step_centre * step_centre * k.x)};
}

double reflectance_at(SigmoidCoefficients coefficients, std::uint32_t bin) {
    const double t = (bin + 0.5) / wavelength_bins;
    return sigmoid((coefficients.c0 * t + coefficients.c1) * t + coefficients.c2);
}

Spectrum reflectance_spectrum(Vec3d rgb) {
    rgb = clamp_to_unit(rgb);
    if (is_grey(rgb)) return constant_spectrum(rgb.x);
    const SigmoidCoefficients c = reflectance_coefficients(rgb);
    Spectrum spectrum;
    for (std::size_t i = 0; i < spectrum_samples; ++i) {
        const double t = static_cast<double>(i) / (spectrum_samples - 1);
        spectrum.samples[i] = static_cast<float>(sigmoid((c.c0 * t + c.c1) * t + c.c2));
    }
    return spectrum;
}

Spectrum light_spectrum(Vec3d rgb) {
    const double brightest = std::max({rgb.x, rgb.y, rgb.z});
    ensure(brightest > 0, "a light's colour has a component above zero");
    // A reflectance of a half leaves room for a smooth curve where one of 1 would have to be a box.
    Spectrum spectrum = reflectance_spectrum(rgb * (0.5 / brightest));
    for (std::size_t i = 0; i < spectrum_samples; ++i)
        spectrum.samples[i] = 2 * spectrum.samples[i] * illuminant_d65().samples[i];
    return spectrum;
}

}  // namespace lumenfarm
