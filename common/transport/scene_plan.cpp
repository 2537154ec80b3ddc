#include "common/transport/scene_plan.h"

#include "common/scene/scene_file.h"
#include "common/support/bytes.h"
#include "common/support/limits.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace lumenfarm {
namespace {

constexpr std::uint64_t plan_magic = 0x004e414c5053464cull;  ///< "LFSPLAN\0"
constexpr std::uint64_t part_magic = 0x005452415053464cull;  ///< "LFSPART\0"
constexpr std::uint32_t version = 2;
static_assert(sizeof(Partition::Node) == 16);

Error damaged(const std::string& what) { return bad_input("the " + what + " is truncated or damaged"); }

bool is_head(ByteReader& in, std::uint64_t magic) {
    const bool right = in.value<std::uint64_t>() == magic;
    return in.value<std::uint32_t>() == version && right && in.good();
}

bool ascends(std::span<const std::uint32_t> numbers) {
    return std::adjacent_find(numbers.begin(), numbers.end(), std::greater_equal<>()) == numbers.end();
}

/// The surface of a triangle of the whole scene. REQUIRES: it has one.
std::size_t surface_of(const ScenePlan& plan, std::uint32_t triangle) {
    const auto& first = plan.first_triangle;
    return static_cast<std::size_t>(std::upper_bound(first.begin(), first.end(), triangle) - first.begin() - 1);
}

Result<void> check_surfaces(const ScenePlan& plan) {
    const auto& first = plan.first_triangle;
    const auto& surfaces = plan.palette.scene.surfaces;
    if (first.size() != surfaces.size() + 1 || first.front() != 0 || first.back() > limits::triangles_max ||
        !ascends(first))
        return damaged("list of surfaces");
    const auto& numbers = plan.palette.numbers;
    if (numbers.size() != plan.palette.scene.triangles.size() || !ascends(numbers)) return damaged("palette");
    for (std::size_t s = 0; s < surfaces.size(); ++s)
        for (std::uint32_t t = 0; t < surfaces[s].triangle_count; ++t)
            if (numbers[surfaces[s].first_triangle + t] != first[s] + t) return damaged("palette");
    for (const Light& light : plan.palette.scene.lights)
        if (light.kind == LightKind::surface &&
            surfaces[light.surface].triangle_count != first[light.surface + 1] - first[light.surface])
            return bad_input("the palette lacks triangles of the light '" + light.name + "'");
    return {};
}

Result<void> check(const ScenePlan& plan) {
    const SceneExtent& extent = plan.extent;
    const auto finite = [](double v) { return std::abs(v) <= limits::coordinate_max_m; };
    if (!finite(extent.centre.x) || !finite(extent.centre.y) || !finite(extent.centre.z) || !(extent.half_m > 0) ||
        !(extent.half_m <= 2 * limits::coordinate_max_m))
        return damaged("extent");
    if (auto good = check_surfaces(plan); !good) return good;
    if (plan.whole.bytes > limits::scene_bytes_max || plan.whole.triangles != plan.first_triangle.back())
        return damaged("name of the scene");
    if (plan.parts.size() != plan.partition.subspaces()) return damaged("list of parts");
    for (const PartFile& part : plan.parts)
        if (part.bytes > limits::scene_bytes_max || part.triangles > plan.first_triangle.back())
            return damaged("list of parts");
    const auto possible = [](std::uint16_t rows) { return rows > 0 && rows <= limits::texel_rows_max; };
    if (!plan.texel_rows.empty() && (plan.texel_rows.size() != plan.first_triangle.back() ||
                                     !std::all_of(plan.texel_rows.begin(), plan.texel_rows.end(), possible)))
        return damaged("list of texels");
    return {};
}

void write(ByteWriter& out, const PartFile& part) {
    for (const std::uint8_t byte : part.file.bytes) out.value(byte);
    out.value(part.bytes);
    out.value(part.triangles);
}

PartFile read_file_name(ByteReader& in) {
    PartFile part;
    for (std::uint8_t& byte : part.file.bytes) byte = in.value<std::uint8_t>();
    part.bytes = in.value<std::uint64_t>();
    part.triangles = in.value<std::uint32_t>();
    return part;
}

}  // namespace

std::vector<std::byte> encode_plan(const ScenePlan& plan) {
    ByteWriter out;
    out.value(plan_magic);
    out.value(version);
    out.block<std::byte>(encode_scene(plan.palette.scene));
    out.block<std::uint32_t>(plan.palette.numbers);
    for (std::size_t axis = 0; axis < 3; ++axis) out.value(plan.extent.centre[axis]);
    out.value(plan.extent.half_m);
    out.block<std::uint32_t>(plan.first_triangle);
    out.block<Partition::Node>(plan.partition.nodes());
    write(out, plan.whole);
    out.value(static_cast<std::uint64_t>(plan.parts.size()));
    for (const PartFile& part : plan.parts) write(out, part);
    out.block<std::uint16_t>(plan.texel_rows);
    return out.take();
}

Result<ScenePlan> decode_plan(std::span<const std::byte> bytes) {
    ByteReader in(bytes);
    if (!is_head(in, plan_magic)) return bad_input("this is not the plan of a scene");
    auto scene = decode_scene(in.block<std::byte>(limits::scene_bytes_max));
    if (!scene) return scene.error();
    ScenePlan plan;
    plan.palette.scene = std::move(*scene);
    plan.palette.numbers = in.block<std::uint32_t>(limits::triangles_max);
    for (std::size_t axis = 0; axis < 3; ++axis) plan.extent.centre[axis] = in.value<double>();
    plan.extent.half_m = in.value<double>();
    plan.first_triangle = in.block<std::uint32_t>(limits::surfaces_max + 1);
    auto partition = Partition::check(in.block<Partition::Node>(2 * limits::subspaces_max - 1));
    if (!in.good()) return damaged("plan of the scene");
    if (!partition) return partition.error();
    plan.partition = std::move(*partition);
    plan.whole = read_file_name(in);
    const auto parts = in.value<std::uint64_t>();
    for (std::uint64_t i = 0; i < parts && in.good(); ++i) plan.parts.push_back(read_file_name(in));
    plan.texel_rows = in.block<std::uint16_t>(limits::triangles_max);
    if (!in.good() || in.remaining() != 0) return damaged("plan of the scene");
    if (const auto good = check(plan); !good) return good.error();
    return plan;
}

std::vector<std::byte> encode_part(const ScenePart& part) {
    ByteWriter out;
    out.value(part_magic);
    out.value(version);
    out.block<Vec3f>(part.scene.positions);
    out.block<Vec2f>(part.scene.uvs);
    out.block<Triangle>(part.scene.triangles);
    out.block<std::uint32_t>(part.numbers);
    return out.take();
}

Result<ScenePart> decode_part(std::span<const std::byte> bytes, const ScenePlan& plan) {
    ByteReader in(bytes);
    if (!is_head(in, part_magic)) return bad_input("this is not a part of a scene");
    ScenePart part;
    Scene& scene = part.scene;
    scene.positions = in.block<Vec3f>(limits::vertices_max);
    scene.uvs = in.block<Vec2f>(limits::vertices_max);
    scene.triangles = in.block<Triangle>(limits::triangles_max);
    part.numbers = in.block<std::uint32_t>(limits::triangles_max);
    const bool whole = in.good() && in.remaining() == 0 && part.numbers.size() == scene.triangles.size() &&
                       ascends(part.numbers) &&
                       (part.numbers.empty() || part.numbers.back() < plan.first_triangle.back());
    if (!whole) return damaged("part of the scene");
    // the surfaces are those of the plan
    for (std::uint32_t t = 0; t < part.numbers.size(); ++t) {
        const std::size_t surface = surface_of(plan, part.numbers[t]);
        if (t == 0 || part.numbers[t - 1] < plan.first_triangle[surface])
            scene.surfaces.push_back({{}, {}, t, 0, plan.palette.scene.surfaces[surface].material});
        ++scene.surfaces.back().triangle_count;
    }
    if (const auto good = validate_geometry(scene); !good) return good.error();
    const bool textured = !plan.palette.scene.textures.empty() && !plan.palette.scene.uvs.empty();
    if (textured && scene.uvs.empty() && !scene.triangles.empty())
        return bad_input("the part of the scene has no texture coordinates");
    return part;
}

}  // namespace lumenfarm
