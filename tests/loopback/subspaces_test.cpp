#include "tests/loopback/farm_fixture.h"

#include <gtest/gtest.h>

#include <string>

/// Jobs of the object-space strategy on workers that have no memory for the whole scene.
namespace lumenfarm::testing {
namespace {

class FarmOfSmallWorkers : public Farm {
protected:
    FarmOfSmallWorkers() {
        SceneBuilder b;
        b.box("room", {0, 0, 0}, {1, 1, 1}, b.lambert(0.7), true);
        b.terrain("hills", 150, 0.25f, b.lambert(0.6));
        const std::uint32_t lamp = b.surface("lamp", b.lambert(0.5));
        b.quad({0.4f, 0.99f, 0.4f}, {0.6f, 0.99f, 0.4f}, {0.6f, 0.99f, 0.6f}, {0.4f, 0.99f, 0.6f});
        b.surface_light(lamp, 1000);
        const auto bytes = encode_scene(b.scene);
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
    const std::string ran = lumenfarm({"run", hills_, "--particles", "200k", "-o", path("ran")});
    start_master();
    const std::vector<std::string> small{"--memory-limit", "85MB"};
    const auto first = start_worker("first", small), second = start_worker("second", small);
    const std::string submitted = submit("64", true);
    EXPECT_EQ(line_after(submitted, "digest "), line_after(ran, "digest "));
    for (const auto& worker : {first.get(), second.get()}) {
        worker->send(SIGTERM);
        EXPECT_EQ(worker->wait(), 0);
        EXPECT_NE(worker->err().find("part_given_up"), std::string::npos) << worker->err();
    }
}

TEST_F(FarmOfSmallWorkers, WorkerThatIsTooSmallSaysSoAndTheJobWaitsForAnother) {
    start_master();
    const auto small = start_worker("small", {"--memory-limit", "74MB"});
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
