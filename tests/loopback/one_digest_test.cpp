#include "cli/embedded_farm.h"
#include "cli/temporary_folder.h"
#include "common/scene/scene_file.h"
#include "tests/scenes/scene_builder.h"

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include <set>
#include <string>
#include <vector>

/// Law 1: what a job gives depends on the scene and the job, and on nothing else.
namespace lumenfarm::testing {
namespace {

constexpr double patience_seconds = 60;

struct Way {
    Packing packing = Packing::automatic;
    std::uint64_t particles_per_set = 0;
    std::uint32_t subspaces = 0;  ///< 0: strategy sets
};
constexpr Way ways[] = {{Packing::records, 1'000}, {Packing::records, 50'000}, {Packing::records, 0},
                        {Packing::maps, 1'000},    {Packing::maps, 50'000},    {Packing::maps, 0},
                        {Packing::records, 0, 8},  {Packing::maps, 1'000, 64}};

std::string describe(const EmbeddedFarm::Options& farm, const Way& way) {
    return std::to_string(farm.workers) + " workers of " + std::to_string(farm.threads) + " threads, " + farm.isa +
           (farm.parts_only ? ", parts only" : "") + ", sets of " + std::to_string(way.particles_per_set) +
           (way.packing == Packing::maps ? ", maps" : ", records") +
           (way.subspaces > 0 ? ", subspaces " + std::to_string(way.subspaces) : "");
}

bool runs(const std::string& isa) {
    return isa == "avx512" ? __builtin_cpu_supports("avx512vl")
           : isa == "avx2" ? __builtin_cpu_supports("avx2")
                           : __builtin_cpu_supports("sse4.2");
}

class OneDigest : public ::testing::TestWithParam<Absorption> {
protected:
    JobSpec spec_of(const Way& way) const {
        JobSpec spec;
        spec.particles = 60'000;
        spec.keep_hits = 500;
        spec.absorption = GetParam();
        spec.packing = way.packing;
        spec.particles_per_set = way.particles_per_set;
        if (way.subspaces > 0) spec.strategy = Strategy::subspaces;
        spec.subspaces = way.subspaces;
        return spec;
    }

    OneDigest() { spdlog::set_level(spdlog::level::err); }

    /// Runs all ways on one farm.
    void run(const EmbeddedFarm::Options& options) {
        const auto storage = TemporaryFolder::make();
        ASSERT_TRUE(storage);
        auto farm = EmbeddedFarm::start(options, *storage);
        ASSERT_TRUE(farm) << farm.error().sentence;
        std::vector<JobId> jobs;
        for (const auto& way : ways) {
            const auto job = (*farm)->master().submit(spec_of(way), scene_bytes_);
            ASSERT_TRUE(job) << job.error().sentence;
            jobs.push_back(*job);
        }
        for (std::size_t i = 0; i < jobs.size(); ++i) {
            SCOPED_TRACE(describe(options, ways[i]));
            const auto status = (*farm)->master().wait(jobs[i], patience_seconds);
            ASSERT_TRUE(status);
            ASSERT_EQ(status->state, wire::JobState::done) << status->sentence;
            EXPECT_EQ(status->packing, ways[i].packing);
            ASSERT_TRUE(status->digest);
            digests_.insert(status->digest->hex());
            EXPECT_EQ(digests_.size(), 1u);
        }
    }

    std::vector<std::byte> scene_bytes_ = encode_scene(mixed_room());
    std::set<std::string> digests_;
};

TEST_P(OneDigest, WhateverTheWorkersThreadsSetsPackingAndInstructions) {
    for (const std::string isa : {"sse4.2", "avx2", "avx512"})
        for (const std::uint32_t workers : {1u, 2u, 3u})
            for (const std::uint32_t threads : {1u, 2u})
                if (runs(isa)) run({workers, threads, isa, 0, (workers + threads) % 2 == 0});
    EXPECT_EQ(digests_.size(), 1u);
}

INSTANTIATE_TEST_SUITE_P(Absorption, OneDigest, ::testing::Values(Absorption::analog, Absorption::attenuate),
                         [](const auto& tested) {
                             return tested.param == Absorption::analog ? "Analog" : "Attenuate";
                         });

}  // namespace
}  // namespace lumenfarm::testing
