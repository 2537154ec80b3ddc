#include "common/scene/scene_file.h"

#include "common/support/bytes.h"
#include "common/support/limits.h"

#include <algorithm>

namespace lumenfarm {
namespace {

constexpr std::uint64_t scene_magic = 0x00454e454353464cull;  ///< "LFSCENE\0"
constexpr std::uint32_t scene_version = 1;

// Elements of the blocks, without padding: the file is their memory.
static_assert(sizeof(Vec3f) == 12 && sizeof(Vec2f) == 8 && sizeof(Triangle) == 12);
static_assert(sizeof(Spectrum) == 4 * spectrum_samples && sizeof(SigmoidCoefficients) == 12);

void write(ByteWriter& out, Vec3d v) {
    for (std::size_t axis = 0; axis < 3; ++axis) out.value(v[axis]);
}
Vec3d read_vec(ByteReader& in) {
    Vec3d v;
    for (std::size_t axis = 0; axis < 3; ++axis) v[axis] = in.value<double>();
    return v;
}

void write_bool(ByteWriter& out, bool value) { out.value(static_cast<std::uint8_t>(value ? 1 : 0)); }
bool read_bool(ByteReader& in) {
    const auto byte = in.value<std::uint8_t>();
    if (byte > 1) in.fail();
    return byte == 1;
}

std::string read_name(ByteReader& in) { return in.text(limits::name_bytes_max); }

void write(ByteWriter& out, const ColorSlot& slot) {
    out.value(slot.spectrum);
    out.value(slot.texture);
}
ColorSlot read_slot(ByteReader& in) {
    ColorSlot slot;
    slot.spectrum = in.value<std::uint32_t>();
    slot.texture = in.value<std::uint32_t>();
    return slot;
}

void write(ByteWriter& out, const Surface& s) {
    out.text(s.name);
    out.text(s.object);
    out.value(s.first_triangle);
    out.value(s.triangle_count);
    out.value(s.material);
}
void read(ByteReader& in, Surface& s) {
    s.name = read_name(in);
    s.object = read_name(in);
    s.first_triangle = in.value<std::uint32_t>();
    s.triangle_count = in.value<std::uint32_t>();
    s.material = in.value<std::uint32_t>();
}

void write(ByteWriter& out, const Material& m) {
    out.text(m.name);
    write(out, m.diffuse);
    write(out, m.mirror);
    write(out, m.transmission);
    out.value(m.dielectric);
    out.value(m.refractive_index);
    write_bool(out, m.thin);
    write_bool(out, m.double_sided);
}
void read(ByteReader& in, Material& m) {
    m.name = read_name(in);
    m.diffuse = read_slot(in);
    m.mirror = read_slot(in);
    m.transmission = read_slot(in);
    m.dielectric = in.value<float>();
    m.refractive_index = in.value<std::uint32_t>();
    m.thin = read_bool(in);
    m.double_sided = read_bool(in);
}

void write(ByteWriter& out, const Texture& t) {
    out.value(t.width);
    out.value(t.height);
    out.value(t.wrap_u);
    out.value(t.wrap_v);
    out.block<SigmoidCoefficients>(t.texels);
}
void read(ByteReader& in, Texture& t) {
    t.width = in.value<std::uint32_t>();
    t.height = in.value<std::uint32_t>();
    t.wrap_u = in.value<Wrap>();
    t.wrap_v = in.value<Wrap>();
    t.texels = in.block<SigmoidCoefficients>(limits::texture_texels_max);
}

void write(ByteWriter& out, const Light& l) {
    out.text(l.name);
    out.value(l.kind);
    out.value(l.spectrum);
    out.value(l.photometric);
    out.value(l.surface);
    write(out, l.position);
    write(out, l.direction);
    out.value(l.cos_inner);
    out.value(l.cos_outer);
    write_bool(out, l.lambertian);
}
void read(ByteReader& in, Light& l) {
    l.name = read_name(in);
    l.kind = in.value<LightKind>();
    l.spectrum = in.value<std::uint32_t>();
    l.photometric = in.value<double>();
    l.surface = in.value<std::uint32_t>();
    l.position = read_vec(in);
    l.direction = read_vec(in);
    l.cos_inner = in.value<double>();
    l.cos_outer = in.value<double>();
    l.lambertian = read_bool(in);
}

void write(ByteWriter& out, const Camera& c) {
    out.text(c.name);
    write(out, c.position);
    write(out, c.forward);
    write(out, c.up);
    out.value(c.vertical_fov_degrees);
    out.value(c.aspect);
}
void read(ByteReader& in, Camera& c) {
    c.name = read_name(in);
    c.position = read_vec(in);
    c.forward = read_vec(in);
    c.up = read_vec(in);
    c.vertical_fov_degrees = in.value<double>();
    c.aspect = in.value<double>();
}

template <class T>
void write_list(ByteWriter& out, const std::vector<T>& elements) {
    out.value(static_cast<std::uint64_t>(elements.size()));
    for (const T& element : elements) write(out, element);
}

/// Grows with what was really read, so a count that lies takes no memory.
template <class T>
std::vector<T> read_list(ByteReader& in, std::uint64_t count_max) {
    const auto count = in.value<std::uint64_t>();
    if (count > count_max) in.fail();
    std::vector<T> elements;
    for (std::uint64_t i = 0; i < count && in.good(); ++i) read(in, elements.emplace_back());
    return elements;
}

Scene read_sections(ByteReader& in) {
    Scene scene;
    scene.positions = in.block<Vec3f>(limits::vertices_max);
    scene.uvs = in.block<Vec2f>(limits::vertices_max);
    scene.triangles = in.block<Triangle>(limits::triangles_max);
    scene.surfaces = read_list<Surface>(in, limits::surfaces_max);
    scene.materials = read_list<Material>(in, limits::materials_max);
    scene.spectra = in.block<Spectrum>(limits::spectra_max);
    scene.textures = read_list<Texture>(in, limits::textures_max);
    scene.lights = read_list<Light>(in, limits::lights_max);
    scene.cameras = read_list<Camera>(in, limits::cameras_max);
    return scene;
}

}  // namespace

std::vector<std::byte> encode_scene(const Scene& scene) {
    ByteWriter out;
    out.value(scene_magic);
    out.value(scene_version);
    out.block<Vec3f>(scene.positions);
    out.block<Vec2f>(scene.uvs);
    out.block<Triangle>(scene.triangles);
    write_list(out, scene.surfaces);
    write_list(out, scene.materials);
    out.block<Spectrum>(scene.spectra);
    write_list(out, scene.textures);
    write_list(out, scene.lights);
    write_list(out, scene.cameras);
    return out.take();
}

Result<Scene> decode_scene(std::span<const std::byte> bytes) {
    if (bytes.size() > limits::scene_bytes_max)
        return bad_input("the compiled scene has " + std::to_string(bytes.size()) + " bytes; the limit is " +
                         std::to_string(limits::scene_bytes_max));
    ByteReader in(bytes);
    if (in.value<std::uint64_t>() != scene_magic)
        return bad_input("this is not a compiled scene: its first bytes differ");
    if (const auto version = in.value<std::uint32_t>(); !in.good() || version != scene_version)
        return bad_input("the compiled scene has format version " + std::to_string(version) + "; this program reads " +
                         std::to_string(scene_version));
    Scene scene = read_sections(in);
    if (!in.good()) return bad_input("the compiled scene is truncated or damaged");
    if (in.remaining() != 0)
        return bad_input("the compiled scene is followed by " + std::to_string(in.remaining()) + " unknown bytes");
    if (auto valid = validate(scene); !valid) return valid.error();
    return scene;
}

Digest scene_digest(std::span<const std::byte> scene_bytes) { return sha256(scene_bytes); }

std::vector<Digest> chunk_digests(std::span<const std::byte> scene_bytes) {
    std::vector<Digest> digests;
    do {
        const std::size_t size = std::min(limits::chunk_bytes, scene_bytes.size());
        digests.push_back(sha256(scene_bytes.first(size)));
        scene_bytes = scene_bytes.subspan(size);
    } while (!scene_bytes.empty());
    return digests;
}

}  // namespace lumenfarm
