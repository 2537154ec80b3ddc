#pragma once

#include "common/math/vec.h"
#include "common/spectrum/spectrum.h"
#include "common/spectrum/upsample.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

/// The compiled scene: flat arrays, SI units, right-handed. Its bytes (scene_file.h) are the only thing daemons parse.
namespace lumenfarm {

inline constexpr std::uint32_t none = 0xffffffffu;  ///< an index that points at nothing

/// Colour over the surface: a spectrum, or a texture of reflectance coefficients times that spectrum.
struct ColorSlot {
    std::uint32_t spectrum = none;  ///< into Scene::spectra; none is zero everywhere
    std::uint32_t texture = none;   ///< into Scene::textures; none is 1 everywhere
    bool operator==(const ColorSlot&) const = default;
};

/// A mixture: with probability `dielectric` a smooth glass boundary (Fresnel; what is transmitted is tinted), otherwise
/// a Lambert reflector with albedo `diffuse` beside a mirror with reflectance `mirror`, diffuse + mirror <= 1.
/// The front of a triangle (counter-clockwise) is the outside of a solid glass.
struct Material {
    std::string name;
    ColorSlot diffuse;
    ColorSlot mirror;
    ColorSlot transmission;                 ///< tint of transmitted light, used where dielectric > 0
    float dielectric = 0;                   ///< in [0, 1]
    std::uint32_t refractive_index = none;  ///< spectrum of n(lambda) >= 1; REQUIRED where dielectric > 0
    bool thin = false;                      ///< glass sheet: all orders of reflection at once, no refraction
    bool double_sided = false;              ///< emission leaves both sides
    bool operator==(const Material&) const = default;
};

/// One mesh primitive: a run of triangles with one material.
struct Surface {
    std::string name;    ///< unique within the scene
    std::string object;  ///< the object (node, group) that the user knows
    std::uint32_t first_triangle = 0;
    std::uint32_t triangle_count = 0;
    std::uint32_t material = 0;
    bool operator==(const Surface&) const = default;
};

enum class LightKind : std::uint8_t { surface, point, spot };

/// Surface: Lambertian, `photometric` is the luminance [cd/m2]. Point and spot: `photometric` is the (axial) luminous
/// intensity [cd]; point with lambertian = true has I(theta) = photometric * cos(theta) about `direction`, 0 behind.
/// Spot: full intensity inside the inner cone, 0 outside the outer, the glTF square falloff
/// clamp((cos - cos_outer) / (cos_inner - cos_outer), 0, 1)^2 between. [KHR_lights_punctual]
struct Light {
    std::string name;
    LightKind kind = LightKind::surface;
    std::uint32_t spectrum = none;  ///< relative spectral power; REQUIRED
    double photometric = 0;         ///< > 0
    std::uint32_t surface = none;   ///< kind surface
    Vec3d position;                 ///< point, spot [m]
    Vec3d direction{0, -1, 0};      ///< spot axis, unit
    double cos_inner = 1;           ///< spot: cos_outer <= cos_inner
    double cos_outer = 0;
    bool lambertian = false;
    bool operator==(const Light&) const = default;
};

/// A pinhole camera: right-handed, looks along `forward`.
struct Camera {
    std::string name;
    Vec3d position;
    Vec3d forward{0, 0, -1};
    Vec3d up{0, 1, 0};
    double vertical_fov_degrees = 45;
    double aspect = 1;  ///< width / height
    bool operator==(const Camera&) const = default;
};

enum class Wrap : std::uint8_t { repeat, mirrored_repeat, clamp };

/// Reflectance coefficients, row by row from v = 0 (the first row of the image file, as glTF has it).
struct Texture {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    Wrap wrap_u = Wrap::repeat;
    Wrap wrap_v = Wrap::repeat;
    std::vector<SigmoidCoefficients> texels;
    bool operator==(const Texture&) const = default;
};

using Triangle = std::array<std::uint32_t, 3>;

struct Scene {
    std::vector<Vec3f> positions;     ///< [m]
    std::vector<Vec2f> uvs;           ///< empty, or one for each position
    std::vector<Triangle> triangles;  ///< of non-zero area; sorted by surface
    std::vector<Surface> surfaces;    ///< cover all triangles in order
    std::vector<Material> materials;
    std::vector<Spectrum> spectra;
    std::vector<Texture> textures;
    std::vector<Light> lights;
    std::vector<Camera> cameras;
    bool operator==(const Scene&) const = default;
};

/// Twice the vector area in double, from the float positions: normal (not unit) of the front side.
Vec3d triangle_cross(const Scene& scene, std::uint32_t triangle);
double triangle_area_m2(const Scene& scene, std::uint32_t triangle);

struct Box {
    Vec3d low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
    bool empty() const { return low.x > high.x; }
};
Box bounding_box(const Scene& scene);

/// For each triangle the surface it belongs to.
std::vector<std::uint32_t> surface_of_triangles(const Scene& scene);

}  // namespace lumenfarm
