#include "proto/archive.h"

#include "common/support/ensure.h"
#include "proto/shared_types.h"
#include "tests/fuzz/fuzzer.h"

#include <algorithm>

using namespace lumenfarm;

namespace {

enum class Choice : std::uint16_t { first, second, third };
constexpr Choice enum_last(Choice) { return Choice::third; }

/// Every kind of field, nested as deep as the bytes say.
struct Anything {
    bool flag = false;
    std::int8_t small = 0;
    std::uint64_t large = 0;
    float ratio = 0;
    double length = 0;
    Choice choice = Choice::first;
    std::string text;
    std::array<std::optional<std::int32_t>, 2> pair;
    std::vector<HitRecord> hits;
    std::optional<EnergyBalance> balance;
    std::vector<Anything> children;
    bool operator==(const Anything&) const = default;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        wire::fields(ar, flag, small, large, ratio, length, choice, wire::at_most(text, 100), pair,
                     wire::block(hits, 1'000), balance, wire::at_most(children, 1'000));
    }
};

std::vector<std::byte> bytes_of(const Anything& value) {
    std::vector<std::byte> bytes;
    wire::OutputArchive archive(bytes);
    archive << value;
    return bytes;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
    const std::span input(reinterpret_cast<const std::byte*>(bytes), size);
    Anything value;
    wire::InputArchive archive(input);
    archive >> value;
    archive.finish();
    if (!archive.refused()) {
        const auto again = bytes_of(value);
        ensure(std::ranges::equal(again, input), "what is accepted is written the same");
    }
    return 0;
}

std::vector<std::vector<std::byte>> lumenfarm::test::corpus_seeds() {
    Anything leaf;
    leaf.flag = true;
    leaf.choice = Choice::third;
    leaf.text = "lumen";
    leaf.pair = {7, std::nullopt};
    leaf.hits.resize(2);
    leaf.balance.emplace();
    Anything tree = leaf;
    tree.children = {leaf, Anything()};
    tree.children[1].children = {leaf};
    return {bytes_of(Anything()), bytes_of(leaf), bytes_of(tree)};
}
