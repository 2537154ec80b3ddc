#include "proto/packing.h"

#include "common/support/ensure.h"
#include "proto/messages.h"
#include "tests/fuzz/fuzzer.h"
#include "tests/scene/sample_scene.h"

using namespace lumenfarm;

/// Result parts from a stranger, merged as the master does: what valid_*() lets through can be added.
namespace {

struct Farm {
    Scene scene = test::sample_scene();
    TexelLayout layout = *TexelLayout::make(scene, 0.3);
    Emission emission;
    Farm() {
        emission.lights.resize(scene.lights.size());
        for (auto& light : emission.lights) light.energy.assign(wavelength_bins, limits::energy_ticks_nominal);
    }
};

const Farm& farm() {
    static const Farm the_farm;
    return the_farm;
}

void merge(const wire::ResultHits& part) {
    const auto absorption = part.energies.empty() ? Absorption::analog : Absorption::attenuate;
    if (!wire::valid_hits(part, farm().scene, absorption)) return;
    LightMap map(farm().layout);
    map.add(farm().emission, part.light, part.records, part.energies);
    // The worker's way with the same hits: every map that really is one is accepted, and merges to the same sums.
    LightMap merged(farm().layout);
    for (const auto& packed : wire::pack_map({}, map.texels(), map.surfaces())) {
        ensure(wire::valid_map(packed, map.texels().size(), map.surfaces().size()), "a true map is valid");
        wire::add_map(packed, merged.texels(), merged.surfaces());
    }
    ensure(merged.texels() == map.texels() && merged.surfaces() == map.surfaces(), "both packings give the same bits");
}

void merge(const wire::ResultMap& part) {
    LightMap map(farm().layout);
    if (!wire::valid_map(part, map.texels().size(), map.surfaces().size())) return;
    wire::add_map(part, map.texels(), map.surfaces());
    std::uint64_t hits = 0;
    for (const auto& texel : map.texels()) hits += texel.hits;
    ensure(hits == wire::hits_of(part).by_texel, "every hit of a part is added once");
}

void merge(const wire::ResultKept& part) {
    if (!wire::valid_kept(part, farm().scene)) return;
    KeptHits kept(3);
    for (const auto& hit : part.hits) kept.offer(hit);
    ensure(kept.sorted().size() <= 3, "no more hits are kept than asked for");
}

template <class Part>
void decode_and_merge(std::span<const std::byte> payload) {
    const auto message = wire::decode(Part::type, payload);
    if (message) merge(std::get<Part>(*message));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
    if (size == 0) return 0;
    const std::span payload(reinterpret_cast<const std::byte*>(bytes) + 1, size - 1);
    switch (*bytes % 3) {
        case 0: decode_and_merge<wire::ResultHits>(payload); break;
        case 1: decode_and_merge<wire::ResultMap>(payload); break;
        default: decode_and_merge<wire::ResultKept>(payload);
    }
    return 0;
}

std::vector<std::vector<std::byte>> lumenfarm::test::corpus_seeds() {
    const HitRecord hit{2, 1'000, 2'000, 3'000, 4'000, 500, hit_flags(3, 4, 1)};
    const wire::PartId part(1, 2, 3);
    const std::vector<wire::Message> parts = {
        wire::ResultHits(part, 0, {hit, hit}, {}),
        wire::ResultHits(part, 1, {hit}, {9'000}),
        wire::ResultMap(part, {{0, 2, 100, 90, 80, 70, 60}, {3, 1, 50, 40, 30, 20, 10}}, {{1, 33, 100, 80, 2}}),
        wire::ResultKept(part, {{hit, 0, 65'000}}),
    };
    std::vector<std::vector<std::byte>> seeds;
    for (const auto& message : parts) {
        const auto frame = wire::encode(message);
        const auto kind = static_cast<int>(wire::type_of(message)) - static_cast<int>(wire::MessageType::result_hits);
        seeds.push_back({static_cast<std::byte>(kind)});
        seeds.back().insert(seeds.back().end(), frame.begin() + limits::frame_header_bytes, frame.end());
    }
    return seeds;
}
