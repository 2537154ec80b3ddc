#include "tests/loopback/farm_fixture.h"
#include "tests/solution/traced_run.h"

#include <gtest/gtest.h>

#include <string>

/// Jobs of the object-space strategy on workers that have no memory for the whole scene.
namespace lumenfarm::testing {
namespace {

class FarmOfSmallWorkers : public Farm {
protected:
    FarmOfSmallWorkers() {
        const auto bytes = encode_scene(hills_room(150));
        hills_ = folder_.write("hills.lfscene", {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    }
    std::string submit(const std::string& subspaces, bool wait) {
        std::vector<std::string> command{"submit",    hills_,        "--particles", "200k",     "--strategy",
                                         "subspaces", "--subspaces", subspaces,     "--master", address_};
        if (wait) command.push_back("--wait");
        return lumenfarm(command);
    }

    std::string hills_;
};

TEST_F(FarmOfSmallWorkers, TogetherTraceWhatNoneOfThemHolds) {
    start_master();
    const std::vector<std::string> small{"--memory-limit", "109MB"};
    const auto first = start_worker("first", small), second = start_worker("second", small);
    const std::string submitted = submit("64", true);
    JobSpec spec;
    spec.particles = 200'000;
    EXPECT_EQ(line_after(submitted, "digest "),
              solution_digest(test::traced_run(hills_room(150), spec).solution).hex());
    for (const auto& worker : {first.get(), second.get()}) {
        worker->send(SIGTERM);
        EXPECT_EQ(worker->wait(), 0);
        EXPECT_NE(worker->err().find("part_given_up"), std::string::npos) << worker->err();
    }
}

TEST_F(FarmOfSmallWorkers, WorkerThatIsTooSmallSaysSoAndTheJobWaitsForAnother) {
    start_master();
    const auto small = start_worker("small", {"--memory-limit", "97MB"});
    submit("8", false);
    EXPECT_TRUE(small->read_until([&] { return small->err().find("memory_too_small") != std::string::npos; }));
    EXPECT_NE(small->err().find("raise the limit, or cut the scene into more subspaces"), std::string::npos)
        << small->err();
    EXPECT_NE(lumenfarm({"why", "1", "--master", address_}).find("could not load"), std::string::npos);
    const auto large = start_worker("large");
    EXPECT_TRUE(until_job(1, [](const wire::JobStatus& job) { return job.state == wire::JobState::done; }));
}

}  // namespace
}  // namespace lumenfarm::testing
