#include "tests/loopback/farm_fixture.h"
#include "tests/solution/traced_run.h"

#include <gtest/gtest.h>

/// Pause, resume, extend, remove and why, as a user types them.
namespace lumenfarm::testing {
namespace {

class ControlledFarm : public Farm {
protected:
    std::string on_job(const std::string& command, std::vector<std::string> more = {}, int status = 0) const {
        more.insert(more.begin(), {command, "1", "--master", address_});
        return lumenfarm(std::move(more), status);
    }
    bool until_state(wire::JobState state) const {
        return until_job(1, [&](const wire::JobStatus& job) { return job.state == state; });
    }
    static std::string digest(std::uint64_t particles) {
        JobSpec spec;
        spec.particles = particles;
        spec.keep_hits = 2'000;
        return solution_digest(test::traced_run(mixed_room(), spec).solution).hex();
    }
    std::string digest_of_job() const {
        const auto status = json({"status", "1", "--json", "--master", address_});
        return std::string(status.at("digest").as_string());
    }
    void submit(const std::string& particles, const std::string& packing) const {
        ASSERT_EQ(lumenfarm({"submit", scene_, "--particles", particles, "--keep-hits", "2k", "--packing", packing,
                             "--particles-per-set", "5k", "--master", address_}),
                  "1\n");
    }
};

TEST_F(ControlledFarm, PausedJobGoesOnWhenItIsResumedThoughTheMasterDiedMeanwhile) {
    start_master();
    const auto worker = start_worker("only");
    submit("1M", "records");
    ASSERT_TRUE(until_job(1, [](const wire::JobStatus& job) { return job.committed > 0; }));
    EXPECT_EQ(on_job("pause"), "job 1 is paused\n");
    // nothing moves any more once what was on its way has arrived
    ASSERT_TRUE(until_job(1, [](const wire::JobStatus& job) { return job.leased == 0; }));
    EXPECT_EQ(on_job("why"), "job 1 is paused; `lumenfarm resume 1` lets it go on\n");
    kill_master();
    start_master();
    EXPECT_TRUE(until_state(wire::JobState::paused));
    EXPECT_EQ(on_job("resume"), "job 1 is resumed\n");
    ASSERT_TRUE(until_state(wire::JobState::done));
    EXPECT_EQ(digest_of_job(), digest(1'000'000));
}

TEST_F(ControlledFarm, ExtendedJobEqualsAFreshOneOfThatSize) {
    start_master();
    const auto first = start_worker("first"), second = start_worker("second");
    submit("400k", "maps");
    ASSERT_TRUE(until_job(1, [](const wire::JobStatus& job) { return job.committed > 0; }));
    EXPECT_EQ(on_job("extend", {"--particles", "600k"}), "job 1 is extended\n");
    ASSERT_TRUE(until_state(wire::JobState::done));
    EXPECT_EQ(digest_of_job(), digest(600'000));

    // and when it was done, over a restart too
    EXPECT_EQ(on_job("extend", {"--particles", "900k"}), "job 1 is extended\n");
    kill_master();
    start_master();
    ASSERT_TRUE(until_state(wire::JobState::done));
    EXPECT_EQ(digest_of_job(), digest(900'000));

    // and when it was cancelled
    on_job("extend", {"--particles", "4G"});
    ASSERT_TRUE(until_job(1, [](const wire::JobStatus& job) { return job.committed > 900'000; }));
    on_job("cancel");
    ASSERT_TRUE(until_state(wire::JobState::cancelled));
    on_job("extend", {"--particles", "1M"}, 2);
}

TEST_F(ControlledFarm, RemovedJobIsGoneWithItsFilesAndItsNumber) {
    start_master();
    const auto worker = start_worker("only");
    submit("10k", "auto");
    ASSERT_TRUE(until_state(wire::JobState::done));
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(path("store/files")), {}), 2);
    EXPECT_EQ(on_job("remove"), "job 1 is removed\n");
    on_job("why", {}, 2);
    EXPECT_TRUE(std::filesystem::is_empty(path("store/files")));
    kill_master();
    start_master();
    EXPECT_EQ(lumenfarm({"submit", scene_, "--particles", "10k", "--master", address_}), "2\n");
}

}  // namespace
}  // namespace lumenfarm::testing
