#include "tests/loopback/farm_fixture.h"
#include "tests/solution/traced_run.h"

#include <gtest/gtest.h>

#include <csignal>
#include <string>
#include <vector>

/// Relays as real processes, between a master and its workers.
namespace lumenfarm::testing {
namespace {

class RelayedFarm : public Farm {
protected:
    static constexpr std::uint64_t particles = 400'000;

    static std::string right_digest(std::uint64_t of_particles = particles) {
        JobSpec spec;
        spec.particles = of_particles;
        spec.keep_hits = 500;
        return solution_digest(test::traced_run(mixed_room(), spec).solution).hex();
    }
    /// Submits a job, and gives its number.
    std::string submit(const std::vector<std::string>& options, std::uint64_t of_particles = particles) const {
        std::vector<std::string> all{"submit",      scene_, "--particles", std::to_string(of_particles),
                                     "--keep-hits", "500",  "--master",    address_};
        all.insert(all.end(), options.begin(), options.end());
        std::string number = lumenfarm(std::move(all));
        if (!number.empty()) number.pop_back();
        return number;
    }
    bool until_done(const std::string& job) const {
        return until_job(std::stoull(job),
                         [](const wire::JobStatus& status) { return status.state == wire::JobState::done; });
    }
    boost::json::object status(const std::string& job) const {
        return json({"status", job, "--json", "--master", address_});
    }
    bool until_it_traces(const std::string& name) const {
        return until_worker(name, [](const wire::WorkerStatus& worker) { return worker.particles > 0; });
    }
    const std::vector<std::vector<std::string>> ways{
        {"--packing", "records"},
        {"--packing", "maps"},
        {"--packing", "records", "--particles-per-set", "1000"},
        {"--packing", "maps", "--absorption", "analog", "--particles-per-set", "50000"},
        {"--packing", "records", "--strategy", "subspaces", "--subspaces", "8"},
        {"--packing", "maps", "--strategy", "subspaces", "--subspaces", "64"}};
};

TEST_F(RelayedFarm, GivesTheDigestOfOneTracerInEveryWay) {
    start_master();
    const Relay relay = start_relay("relay");
    const auto first = start_worker("first", {}, relay.address);
    const std::string right = right_digest();
    const auto expect_right = [&] {
        for (const auto& way : ways) {
            SCOPED_TRACE(::testing::PrintToString(way));
            const std::string job = submit(way);
            ASSERT_TRUE(until_done(job));
            EXPECT_EQ(status(job).at("digest").as_string(), right);
        }
    };
    {
        SCOPED_TRACE("one worker behind a relay");
        expect_right();
    }
    const Relay below = start_relay("below", {}, {}, relay.address);
    const auto second = start_worker("second", {}, relay.address);
    const auto third = start_worker("third", {"--parts-only"}, below.address);
    const auto fourth = start_worker("fourth", {}, below.address);
    const auto direct = start_worker("direct");
    ASSERT_TRUE(until_worker("relay", [](const wire::WorkerStatus& status) { return status.threads == 4; }));
    SCOPED_TRACE("a tree of relays");
    expect_right();
    EXPECT_TRUE(until_farm([](const wire::StatusReply& farm) {
        return counted(farm, "results_not_merged", {"result_invalid", "result_stale"}) +
                   counted(farm, "leases_ended", {"lease_expired"}) + counted(farm, "sent_off", {"protocol_error"}) ==
               0;
    }));
}

TEST_F(RelayedFarm, IsShownAsOneWorkerWithTheThreadsOfAll) {
    start_master();
    const Relay relay = start_relay("hall 2");
    const auto first = start_worker("first", {}, relay.address);
    ASSERT_TRUE(until_worker("hall 2", [](const wire::WorkerStatus& worker) {
        return worker.role == wire::Role::relay && worker.threads == 1;
    }));
    const auto second = start_worker("second", {}, relay.address);
    ASSERT_TRUE(until_worker("hall 2", [](const wire::WorkerStatus& worker) { return worker.threads == 2; }));
    const std::string table = lumenfarm({"workers", "--master", address_});
    EXPECT_NE(table.find("relay"), std::string::npos) << table;
    const std::string below = lumenfarm({"workers", "--master", relay.address});
    EXPECT_NE(below.find("first"), std::string::npos) << below;
    EXPECT_NE(below.find("second"), std::string::npos) << below;
}

TEST_F(RelayedFarm, RelayThatIsStoppedInTheMiddleHandsUpWhatIsDone) {
    start_master();
    const Relay relay = start_relay("relay");
    const auto behind = start_worker("behind", {}, relay.address);
    const std::string job = submit({"--packing", "maps"}, 10'000'000);
    ASSERT_TRUE(until_it_traces("relay"));
    relay.process->send(SIGTERM);
    EXPECT_EQ(relay.process->wait(), 0) << relay.process->err();
    EXPECT_NE(relay.process->err().find("drained: "), std::string::npos);
    const auto direct = start_worker("direct");
    ASSERT_TRUE(until_done(job));
    EXPECT_EQ(status(job).at("digest").as_string(), right_digest(10'000'000));
    EXPECT_EQ(status(job).at("results_stale").to_number<std::uint64_t>(), 0u);
    EXPECT_EQ(status(job).at("leases_expired").to_number<std::uint64_t>(), 0u);
}

TEST_F(RelayedFarm, RelayThatComesLateHelps) {
    start_master();
    const auto direct = start_worker("direct");
    const std::string job = submit({}, 10'000'000);
    ASSERT_TRUE(until_it_traces("direct"));
    const Relay relay = start_relay("relay");
    const auto behind = start_worker("behind", {}, relay.address);
    EXPECT_TRUE(until_it_traces("relay"));
    ASSERT_TRUE(until_done(job));
    EXPECT_EQ(status(job).at("digest").as_string(), right_digest(10'000'000));
}

TEST_F(RelayedFarm, CancelledAndPausedJobsStopBehindARelay) {
    start_master();
    const Relay relay = start_relay("relay");
    const auto behind = start_worker("behind", {}, relay.address);
    const std::string job = submit({"--packing", "maps"}, 2'000'000'000);
    ASSERT_TRUE(until_it_traces("relay"));
    lumenfarm({"pause", job, "--master", address_});
    ASSERT_TRUE(until_job(std::stoull(job), [](const wire::JobStatus& status) {
        return status.state == wire::JobState::paused && status.leased == 0;
    }));
    lumenfarm({"resume", job, "--master", address_});
    ASSERT_TRUE(until_worker("relay", [](const wire::WorkerStatus& worker) { return worker.leases > 0; }));
    lumenfarm({"cancel", job, "--master", address_});
    ASSERT_TRUE(until_job(std::stoull(job),
                          [](const wire::JobStatus& status) { return status.state == wire::JobState::cancelled; }));
    const std::string out = path("out");
    lumenfarm({"fetch", job, "-o", out, "--master", address_});
    EXPECT_TRUE(json({"inspect", out, "--json"}).at("balance").as_object().at("ticks_equal").as_bool());
}

TEST_F(RelayedFarm, WaitsForAMasterThatIsNotThereYet) {
    start_master();
    kill_master();
    const Relay relay = start_relay("relay");
    const auto behind = start_worker("behind", {}, relay.address);
    ASSERT_TRUE(relay.process->read_until(
        [&] { return relay.process->err().find("trying again until the master is there") != std::string::npos; }));
    start_master();
    const std::string job = submit({});
    ASSERT_TRUE(until_done(job));
    EXPECT_EQ(status(job).at("digest").as_string(), right_digest());
}

TEST_F(RelayedFarm, SendsSubmittersToItsMaster) {
    start_master();
    const Relay relay = start_relay("relay");
    const auto process = start("lumenfarm", {"submit", scene_, "--particles", "1000", "--master", relay.address});
    EXPECT_EQ(process->wait(), 2);
    EXPECT_NE(process->err().find("this is a relay: ask its master at " + address_), std::string::npos)
        << process->err();
}

TEST_F(RelayedFarm, RelayThatIsItsOwnUpstreamSaysSo) {
    start_master();
    const Relay relay = start_relay("relay");
    relay.process->send(SIGTERM);
    ASSERT_EQ(relay.process->wait(), 0);
    const Relay own = start_relay("own", {}, relay.address, relay.address);
    EXPECT_EQ(own.process->wait(), 1);
    EXPECT_NE(own.process->err().find("this relay is its own upstream; --upstream is to name its master"),
              std::string::npos)
        << own.process->err();
}

TEST_F(RelayedFarm, RelayOfWrongOptionsSaysSo) {
    const auto refused = [&](std::vector<std::string> options) {
        options.insert(options.begin(), {"--storage", path("wrong"), "--listen", "127.0.0.1:0"});
        const auto process = start("lumenfarm-master", std::move(options));
        EXPECT_EQ(process->wait(), 2) << process->err();
        return process->err();
    };
    EXPECT_NE(refused({"--upstream", "nonsense"}).find("nonsense"), std::string::npos);
    EXPECT_NE(refused({"--upstream", "127.0.0.1:99999"}).find("99999"), std::string::npos);
    EXPECT_NE(refused({"--upstream", "127.0.0.1:1", "--audit-fraction", "0.5"}).find("--upstream"), std::string::npos);
}

}  // namespace
}  // namespace lumenfarm::testing
