#include "tests/loopback/farm_fixture.h"
#include "tests/solution/traced_run.h"

#include <gtest/gtest.h>

#include <filesystem>

/// Daemons that are told to end (SIGTERM) in the midst of a job.
namespace lumenfarm::testing {
namespace {

class EndingFarm : public Farm {
protected:
    void submit(const std::string& particles, const std::string& per_set = "20k") {
        ASSERT_EQ(lumenfarm({"submit", scene_, "--particles", particles, "--particles-per-set", per_set, "--packing",
                             "records", "--master", address_}),
                  "1\n");
    }
    bool until_committed(std::uint64_t particles) const {
        return until_job(1, [&](const wire::JobStatus& job) { return job.committed >= particles; });
    }
    void end_master() {
        master_->send(SIGTERM);
        EXPECT_EQ(master_->wait(), 0) << master_->err();
    }
    /// Ends a worker in order, and gives how many of its particles were acknowledged.
    static std::uint64_t end_worker(Process& worker) {
        worker.send(SIGTERM);
        EXPECT_EQ(worker.wait(), 0) << worker.err();
        const auto at = worker.err().find("drained: ");
        EXPECT_NE(at, std::string::npos) << worker.err();
        return at == std::string::npos ? 0 : std::stoull(worker.err().substr(at + 9));
    }
    bool until_leases_are_back() const {
        return until_job(1, [](const wire::JobStatus& job) { return job.leases_returned > 0 && job.leased == 0; });
    }
    void expect_nothing_expired() const {
        EXPECT_TRUE(until_job(1, [](const wire::JobStatus& job) {
            EXPECT_EQ(job.leases_expired, 0u);
            return true;
        }));
    }
};

TEST_F(EndingFarm, StoppedMasterGoesOnFromItsSnapshotAndNothingAcknowledgedIsTracedAgain) {
    constexpr std::uint64_t particles = 1'000'000;
    // no snapshot but those of the end
    const std::vector<std::string> options{"--checkpoint-seconds", "1000"};
    start_master(options);
    const auto first = start_worker("first"), second = start_worker("second");
    submit("1M", "5k");
    for (const std::uint64_t committed : {particles / 5, particles / 2}) {
        ASSERT_TRUE(until_committed(committed));
        end_master();
        EXPECT_NE(master_->err().find("a snapshot of job 1 is kept"), std::string::npos) << master_->err();
        EXPECT_TRUE(std::filesystem::is_empty(path("store/segments")));
        start_master(options);
    }
    ASSERT_TRUE(until_job(1, [](const wire::JobStatus& job) { return job.state == wire::JobState::done; }));
    EXPECT_EQ(master_->err().find("traced again"), std::string::npos) << master_->err();
    EXPECT_EQ(end_worker(*first) + end_worker(*second), particles) << "each was acknowledged once";
    JobSpec spec;
    spec.particles = particles;
    EXPECT_EQ(json({"status", "1", "--json", "--master", address_}).at("digest").as_string(),
              solution_digest(test::traced_run(mixed_room(), spec).solution).hex());
}

TEST_F(EndingFarm, StoppedWorkerHandsBackItsLeases) {
    start_master();
    const auto worker = start_worker("only");
    submit("4G", "50M");
    ASSERT_TRUE(until_worker("only", [](const wire::WorkerStatus& status) { return status.leases > 0; }));
    const std::uint64_t merged = end_worker(*worker);
    EXPECT_TRUE(until_leases_are_back());
    EXPECT_TRUE(until_job(1, [&](const wire::JobStatus& job) { return job.committed == merged; }));
    expect_nothing_expired();
}

TEST_F(EndingFarm, WorkerEndsWithinItsDrainTimeThoughTheMasterIsSilent) {
    start_master();
    const auto worker = start_worker("only", {"--drain-seconds", "0.5"});
    // what is on its way fits what the system holds for a silent master, and the goodbye behind it
    submit("4G", "1000");
    ASSERT_TRUE(until_committed(1));
    master_->send(SIGSTOP);
    worker->send(SIGTERM);
    EXPECT_EQ(worker->wait(), 0) << worker->err();
    master_->send(SIGCONT);
    EXPECT_TRUE(until_leases_are_back());
    expect_nothing_expired();
}

TEST_F(EndingFarm, ASecondSignalEndsAWorkerAtOnceAndItsLeasesAreHandedBack) {
    start_master();
    const auto worker = start_worker("only", {"--drain-seconds", "86400"});
    // what is on its way fits what the system holds for a silent master, and the goodbye behind it
    submit("4G", "1000");
    ASSERT_TRUE(until_committed(1));
    master_->send(SIGSTOP);
    worker->send(SIGTERM);
    ASSERT_TRUE(worker->read_until([&] {
        return worker->err().find("the worker hands back its work") != std::string::npos;
    })) << worker->err();
    worker->send(SIGTERM);
    EXPECT_EQ(worker->wait(), 0) << worker->err();
    EXPECT_NE(worker->err().find("again: the worker ends at once"), std::string::npos) << worker->err();
    master_->send(SIGCONT);
    EXPECT_TRUE(until_leases_are_back());
    expect_nothing_expired();
}

}  // namespace
}  // namespace lumenfarm::testing
