#include "master/result_fingerprint.h"
#include "proto/packing.h"
#include "tests/master/master_fixture.h"

#include <gtest/gtest.h>

namespace lumenfarm::testing {
namespace {

constexpr std::uint64_t key = 99, half = std::uint64_t{1} << 63;

class FingerprintTest : public ::testing::TestWithParam<Packing> {
protected:
    FingerprintTest() {
        spec_.particles = 4'000;
        spec_.keep_hits = 100;
        spec_.packing = GetParam();
        prepared_ = prepare_job(spec_, encode_scene(small_scene())).value();
        tracer_ = std::make_unique<FakeTracer>(prepared_->scene);
    }

    /// As an honest worker packs it; `lie` changes the messages before they are sent.
    template <class Lie>
    std::uint64_t fingerprint(const ParticleRange& range, Lie lie) const {
        TracedHits hits;
        tracer_->trace(spec_, range, hits, nullptr);
        StagedResult result(1, 1);
        const auto add = [&](auto part) {
            lie(part);
            result.add(spec_, *prepared_, std::move(part));
        };
        std::uint32_t parts = 0;
        if (spec_.packing == Packing::records) {
            for (auto& part : wire::pack_hits(wire::PartId(1, 1, 0), range.source, hits.records, hits.energies, 400)) {
                add(std::move(part));
                ++parts;
            }
        } else {
            LightMap sums(prepared_->layout);
            sums.add(tracer_->emission(), range.source, hits.records, hits.energies);
            for (auto& part : wire::pack_map(wire::PartId(1, 1, 0), sums.texels(), sums.surfaces())) {
                add(std::move(part));
                ++parts;
            }
            std::vector<KeptHit> kept;
            const auto& energy = tracer_->emission().lights[range.source].energy;
            for (const HitRecord& record : hits.records)
                kept.push_back({record, range.source, energy[record.wavelength]});
            for (auto& part : wire::pack_kept(wire::PartId(1, 1, parts), kept)) {
                add(std::move(part));
                ++parts;
            }
        }
        const auto whole =
            result.complete(*prepared_, wire::ResultDone(1, 1, {wire::Claim(1, 1, range)}, parts, hits.balance, 1, 1));
        EXPECT_TRUE(whole) << whole.error().sentence;
        return result_fingerprint(result, half, key);
    }
    std::uint64_t fingerprint(const ParticleRange& range) const {
        return fingerprint(range, [](auto&) {});
    }

    JobSpec spec_;
    std::shared_ptr<const PreparedJob> prepared_;
    std::unique_ptr<FakeTracer> tracer_;
};

TEST_P(FingerprintTest, PartsSumToTheWhole) {
    EXPECT_EQ(fingerprint({0, 0, 700}) + fingerprint({0, 700, 300}), fingerprint({0, 0, 1'000}));
    EXPECT_NE(fingerprint({0, 0, 1'000}), fingerprint({0, 1'000, 1'000}));
}

TEST_P(FingerprintTest, OneFlippedBitShows) {
    const ParticleRange range{1, 0, 500};
    const std::uint64_t truth = fingerprint(range);
    for (int bit = 0; bit < 8; ++bit) {
        const auto flip = [&]<class Part>(Part& part) {
            if constexpr (std::is_same_v<Part, wire::ResultHits>)
                part.records[17].direction_u ^= static_cast<std::uint16_t>(1u << bit);
            if constexpr (std::is_same_v<Part, wire::ResultMap>) part.texels[3].x ^= 1ll << bit;
        };
        EXPECT_NE(fingerprint(range, flip), truth);
    }
}

INSTANTIATE_TEST_SUITE_P(Packings, FingerprintTest, ::testing::Values(Packing::records, Packing::maps));

}  // namespace
}  // namespace lumenfarm::testing
