#include "tests/loopback/farm_fixture.h"
#include "tests/solution/traced_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <map>
#include <random>
#include <thread>

/// Daemons that are killed (SIGKILL) at random instants. LUMENFARM_TEST_KILLS: how often; a few by default.
namespace lumenfarm::testing {
namespace {

class CrashingFarm : public Farm {
protected:
    /// Memory for a part of the subspaces of this scene only, beside its light maps, which take some 5 MB.
    const std::vector<std::string> few_subspaces{"--memory-limit", "104MB", "--parts-only"};

    static int kills() {
        const char* wanted = std::getenv("LUMENFARM_TEST_KILLS");
        return wanted ? std::atoi(wanted) : 4;
    }
    std::chrono::milliseconds some_time() {
        return std::chrono::milliseconds(std::uniform_int_distribution(0, 1'500)(random_));
    }

    /// One job after the other, each of another seed, with every packing and strategy in turn.
    void submit_next() {
        ++jobs_;
        const std::string job = std::to_string(jobs_);
        const bool maps = jobs_ % 4 >= 2, subspaces = jobs_ % 2 == 0;
        ASSERT_EQ(lumenfarm({"submit", scene_, "--particles", "3M", "--particles-per-set", "20k", "--seed", job,
                             "--packing", maps ? "maps" : "records", "--strategy", subspaces ? "subspaces" : "sets",
                             "--subspaces", "64", "--keep-hits", "500", "--master", address_}),
                  job + "\n");
    }
    bool last_job_is_over() {
        master_->read_now();
        const auto state = json({"status", std::to_string(jobs_), "--json", "--master", address_}).at("state");
        return state != "queued" && state != "running";
    }
    /// Every job has ended as it would have in one process without a crash.
    void expect_right_digests() {
        for (std::uint64_t job = 1; job <= jobs_; ++job) {
            SCOPED_TRACE(job);
            ASSERT_TRUE(
                until_job(job, [](const wire::JobStatus& status) { return status.state == wire::JobState::done; }));
            const auto status = json({"status", std::to_string(job), "--json", "--master", address_});
            JobSpec spec;
            spec.particles = 3'000'000;
            spec.seed = job;
            spec.keep_hits = 500;
            EXPECT_EQ(status.at("digest").as_string(),
                      solution_digest(test::traced_run(mixed_room(), spec).solution).hex());
            EXPECT_EQ(status.at("results_invalid").to_number<std::uint64_t>(), 0u);
        }
    }

    std::mt19937 random_{std::random_device{}()};
    std::uint64_t jobs_ = 0;
};

TEST_F(CrashingFarm, KilledMastersStartAgainWithoutHelpAndLoseNothing) {
    start_master({"--checkpoint-seconds", "0.5"});
    const auto first = start_worker("first", few_subspaces), second = start_worker("second", few_subspaces);
    submit_next();
    for (int kill = 0; kill < kills(); ++kill) {
        std::this_thread::sleep_for(some_time());
        kill_master();
        EXPECT_EQ(master_->err().find("traced again"), std::string::npos) << master_->err();
        start_master({"--checkpoint-seconds", "0.5"});
        if (last_job_is_over()) submit_next();
    }
    expect_right_digests();
}

TEST_F(CrashingFarm, KilledWorkersAreReplacedAndChangeNothing) {
    start_master();
    std::map<int, std::unique_ptr<Process>> workers;
    for (int i = 0; i < 3; ++i) workers[i] = start_worker(std::to_string(i), few_subspaces);
    submit_next();
    for (int kill = 0; kill < kills(); ++kill) {
        std::this_thread::sleep_for(some_time() / 4);
        auto& worker = workers[kill % 3];
        worker->send(SIGKILL);
        EXPECT_EQ(worker->wait(), -SIGKILL) << worker->err();
        worker = start_worker(std::to_string(kill % 3), few_subspaces);
        if (last_job_is_over()) submit_next();
    }
    expect_right_digests();
}

TEST_F(CrashingFarm, KilledRelaysAndTheirWorkersAreReplacedAndChangeNothing) {
    start_master();
    Relay relay = start_relay("relay");
    Relay below = start_relay("below", {}, {}, relay.address);
    const auto direct = start_worker("direct", few_subspaces);
    auto first = start_worker("first", few_subspaces, relay.address);
    const auto second = start_worker("second", few_subspaces, below.address);
    submit_next();
    for (int kill = 0; kill < kills(); ++kill) {
        std::this_thread::sleep_for(some_time() / 4);
        const auto end = [](Process& process) {
            process.send(SIGKILL);
            EXPECT_EQ(process.wait(), -SIGKILL) << process.err();
        };
        if (kill % 3 == 0) {
            end(*relay.process);
            relay = start_relay("relay", {}, relay.address);
        } else if (kill % 3 == 1) {
            end(*below.process);
            below = start_relay("below", {}, below.address, relay.address);
        } else {
            end(*first);
            first = start_worker("first", few_subspaces, relay.address);
        }
        if (last_job_is_over()) submit_next();
    }
    expect_right_digests();
}

/// Calls around which a master writes, makes it last, commits and acknowledges.
struct FailPoint {
    const char* call;
    int last;  ///< a life has at least so many of them
};
void PrintTo(const FailPoint& point, std::ostream* out) { *out << point.call; }

class FailPoints : public CrashingFarm, public ::testing::WithParamInterface<FailPoint> {};

TEST_P(FailPoints, MasterThatIsKilledThereStartsAgainAndLosesNothing) {
    if (!can_inject()) GTEST_SKIP() << "strace can't be used here";
    start_master();
    const auto first = start_worker("first", few_subspaces), second = start_worker("second", few_subspaces);
    submit_next();
    kill_master();
    const auto [called, last] = GetParam();
    const std::string call = called;
    const int step = std::max(1, last / kills());
    int killed = 0;
    for (int at = 1; at <= last; at += step) {
        launch_master({"--checkpoint-seconds", "0.3"},
                      {"strace", "-D", "-f", "-o", "/dev/null", "-e", "trace=" + call, "-e",
                       "inject=" + call + ":signal=SIGKILL:when=" + std::to_string(at)});
        if (master_listens())
            until_job(jobs_, [](const wire::JobStatus& job) { return job.state == wire::JobState::done; });
        master_->send(SIGTERM);
        killed += master_->wait() == -SIGKILL;
        EXPECT_EQ(master_->err().find("traced again"), std::string::npos) << master_->err();
        start_master();
        if (last_job_is_over()) submit_next();
        kill_master();
    }
    EXPECT_GT(killed, 0);
    start_master();
    expect_right_digests();
}

INSTANTIATE_TEST_SUITE_P(Calls, FailPoints,
                         ::testing::Values(FailPoint{"pwrite64", 60}, FailPoint{"fdatasync", 42}, FailPoint{"fsync", 3},
                                           FailPoint{"unlink", 2}, FailPoint{"sendmsg", 42}),
                         [](const auto& tested) { return std::string(tested.param.call); });

}  // namespace
}  // namespace lumenfarm::testing
