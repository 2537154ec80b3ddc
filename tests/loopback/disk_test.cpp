#include "tests/loopback/farm_fixture.h"
#include "tests/solution/traced_run.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

/// A real master on a disk that is full, or fails.
namespace lumenfarm::testing {
namespace {

namespace fs = std::filesystem;

class FarmOnABadDisk : public Farm {
protected:
    void submit() {
        ASSERT_EQ(lumenfarm({"submit", scene_, "--particles", "3M", "--particles-per-set", "20k", "--packing",
                             "records", "--texel", "0.2", "--master", address_}),
                  "1\n");
    }
    void expect_right_digest() {
        if (!until_job(1, [](const wire::JobStatus& job) { return job.state == wire::JobState::done; })) {
            master_->send(SIGTERM);
            master_->wait();
            FAIL() << master_->err();
        }
        const auto status = json({"status", "1", "--json", "--master", address_});
        JobSpec spec;
        spec.particles = 3'000'000;
        spec.texel_m = 0.2;
        EXPECT_EQ(status.at("digest").as_string(),
                  solution_digest(test::traced_run(mixed_room(), spec).solution).hex());
    }
};

TEST_F(FarmOnABadDisk, FullDiskPausesTheJobWithItsReasonAndItGoesOnWhenThereIsRoom) {
    const std::vector<std::string> apart = {"unshare", "--user", "--map-root-user", "--mount", "sh", "-c"};
    // without the ballast all that a job of this size can write has room, at whatever instant it fills
    const std::string mount = "mkdir -p " + path("store") + " && mount -t tmpfs -o size=1G none " + path("store");
    auto trial = apart;
    trial.push_back(mount);
    if (!succeeds(trial)) GTEST_SKIP() << "no file system can be mounted here";
    auto under = apart;
    under.push_back(mount + " && head -c 1022M /dev/zero > " + path("store") + R"(/ballast && exec "$@")");
    under.push_back("sh");
    launch_master({"--checkpoint-seconds", "0.3"}, under);
    ASSERT_TRUE(master_listens()) << master_->err();
    const auto worker = start_worker("only");
    submit();
    const auto full = [](const wire::JobStatus& job) {
        return job.state == wire::JobState::running &&
               job.sentence.find("No space left on device") != std::string::npos;
    };
    ASSERT_TRUE(until_job(1, full));
    const auto status = json({"status", "1", "--json", "--master", address_});
    EXPECT_LT(status.at("committed").to_number<std::uint64_t>(), 3'000'000u);
    // the file system of the master's own, seen from here
    ASSERT_TRUE(fs::remove("/proc/" + std::to_string(master_->id()) + "/root" + path("store") + "/ballast"));
    expect_right_digest();
    EXPECT_EQ(json({"status", "1", "--json", "--master", address_}).at("leases_expired").to_number<std::uint64_t>(),
              0u);
}

TEST_F(FarmOnABadDisk, DiskThatFailsEndsTheMasterAndTheNextOneGoesOn) {
    if (!can_inject()) GTEST_SKIP() << "strace can't be used here";
    start_master();
    const auto first = start_worker("first"), second = start_worker("second");
    submit();
    kill_master();
    for (const char* fault : {"fdatasync:error=EIO:when=25+", "pwrite64:error=EIO:when=60+"}) {
        const std::string call(fault, std::string_view(fault).find(':'));
        launch_master(
            {}, {"strace", "-D", "-f", "-o", "/dev/null", "-e", "trace=" + call, "-e", std::string("inject=") + fault});
        EXPECT_EQ(master_->wait(), 1);
        EXPECT_NE(master_->err().find("recovers from its disk when it starts again"), std::string::npos)
            << master_->err();
        EXPECT_EQ(master_->err().find("traced again"), std::string::npos) << master_->err();
    }
    start_master();
    expect_right_digest();
}

}  // namespace
}  // namespace lumenfarm::testing
