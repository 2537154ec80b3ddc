#include "tests/loopback/network.h"
#include "tests/loopback/farm_fixture.h"
#include "tests/solution/traced_run.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <map>
#include <memory>
#include <random>
#include <thread>

/// A farm of machines whose network fails, and machines that stand still. LUMENFARM_TEST_FAULTS: how often; a few by
/// default. LUMENFARM_TEST_FAULT_SECONDS: a fault lasts so long, and the master has its usual patience with it; by
/// default the master is told to have little, and a fault lasts until it was noticed and some time more.
namespace lumenfarm::testing {
namespace {

constexpr std::uint64_t particles = 6'000'000;

double setting(const char* name, double usual) {
    const char* wanted = std::getenv(name);
    return wanted ? std::atof(wanted) : usual;
}

class FarmOnABadNetwork : public Farm {
protected:
    static void SetUpTestSuite() { network_ = std::make_unique<OwnNetwork>(); }
    static void TearDownTestSuite() { network_.reset(); }

    void SetUp() override {
        if (!network_->works()) GTEST_SKIP() << "no network of its own can be made here, or there is no ip or nft";
        for (int number = 1; number <= 2; ++number) hosts_.push_back(std::make_unique<Host>(number));
        for (const auto& host : hosts_) ASSERT_TRUE(host->works());
    }
    static int faults() { return static_cast<int>(setting("LUMENFARM_TEST_FAULTS", 2)); }

    void start_farm() {
        address_ = "0.0.0.0:0";
        std::vector<std::string> options = {"--allow-plaintext"};
        if (fault_s_ == 0) options.insert(options.end(), {"--dead-seconds", "1", "--reconnect-seconds", "1"});
        start_master(options);
        for (std::size_t i = 0; i < hosts_.size(); ++i) start_worker_on(i);
        submit_next();
        for (std::size_t i = 0; i < hosts_.size(); ++i) ASSERT_TRUE(until_worker_works(i));
    }
    static std::string name_of(std::size_t host) { return "host" + std::to_string(host); }
    void start_worker_on(std::size_t host) {
        const std::string port = address_.substr(address_.rfind(':'));
        auto command = hosts_[host]->inside(
            {program("lumenfarm-worker"), "--master", hosts_[host]->outer_address() + port, "--threads", "1",
             "--normal-priority", "--name", name_of(host), "--cache", path("cache-" + name_of(host))});
        command.insert(command.begin(), "/usr/bin/env");
        workers_[host] = std::make_unique<Process>(std::move(command));
    }
    bool until_worker_works(std::size_t host) const {
        return until_worker(name_of(host),
                            [](const wire::WorkerStatus& worker) { return worker.silent_seconds < 0.5; });
    }

    /// The same again and again, in both packings: they have one digest.
    void submit_next() {
        ++jobs_;
        ASSERT_EQ(
            lumenfarm({"submit", scene_, "--particles", std::to_string(particles), "--particles-per-set", "20k",
                       "--packing", jobs_ % 2 == 0 ? "maps" : "records", "--keep-hits", "500", "--master", address_}),
            std::to_string(jobs_) + "\n");
    }
    void keep_busy() {
        master_->read_now();
        for (auto& [host, worker] : workers_) worker->read_now();
        const auto state = json({"status", std::to_string(jobs_), "--json", "--master", address_}).at("state");
        if (state != "queued" && state != "running") submit_next();
    }

    std::uint64_t lost_now() const {
        std::uint64_t lost = 0;
        EXPECT_TRUE(until_farm([&](const wire::StatusReply& farm) {
            lost = lost_connections(farm);
            return true;
        }));
        return lost;
    }
    static std::uint64_t lost_connections(const wire::StatusReply& farm) {
        return counted(farm, "connections_closed",
                       {"silent", "write_stalled", "network_error", "half_frame", "by_peer"});
    }
    /// A fault lasts until the master has closed a connection, or as long as it was set to.
    void last(std::uint64_t lost_before) {
        const auto end = Clock::now() + std::chrono::duration<double>(fault_s_);
        while (Clock::now() < end) {
            keep_busy();
            std::this_thread::sleep_for(std::chrono::milliseconds(200));
        }
        if (fault_s_ > 0) return;
        ASSERT_TRUE(until_farm([&](const wire::StatusReply& farm) { return lost_connections(farm) > lost_before; }));
        std::this_thread::sleep_for(std::chrono::milliseconds(std::uniform_int_distribution(0, 2'000)(random_)));
    }

    /// Every job has ended as it would have in one process: each particle once, and the same bits.
    void expect_right_results() {
        JobSpec spec;
        spec.particles = particles;
        spec.keep_hits = 500;
        const Solution wanted = test::traced_run(mixed_room(), spec).solution;
        const std::string digest = solution_digest(wanted).hex();
        for (std::uint64_t job = 1; job <= jobs_; ++job) {
            SCOPED_TRACE(job);
            ASSERT_TRUE(
                until_job(job, [](const wire::JobStatus& status) { return status.state == wire::JobState::done; }));
            const auto status = json({"status", std::to_string(job), "--json", "--master", address_});
            EXPECT_EQ(status.at("digest").as_string(), digest);
            EXPECT_EQ(status.at("committed").to_number<std::uint64_t>(), particles);
            EXPECT_EQ(status.at("hits").to_number<std::uint64_t>(), wanted.balance.hits);
            EXPECT_EQ(status.at("results_invalid").to_number<std::uint64_t>(), 0u);
        }
    }
    /// What `lumenfarm status --json` says now; also shown with the test's result.
    boost::json::object counts() {
        const auto counts = json({"status", "--json", "--master", address_}).at("counts").as_object();
        for (const auto& [group, reasons] : counts)
            for (const auto& [reason, count] : reasons.as_object())
                if (count.to_number<std::uint64_t>() > 0)
                    RecordProperty(std::string(reason), std::to_string(count.to_number<std::uint64_t>()));
        return counts;
    }
    static std::uint64_t count(const boost::json::object& counts, std::string_view group, std::string_view reason) {
        return counts.at(group).as_object().at(reason).to_number<std::uint64_t>();
    }

    /// So many connections, at least, were closed for want of life.
    static void expect_noticed(const boost::json::object& counts, int faults) {
        std::uint64_t lost = 0;
        for (const char* reason : {"silent", "write_stalled", "network_error"})
            lost += count(counts, "connections_closed", reason);
        EXPECT_GE(lost, static_cast<std::uint64_t>(faults));
    }

    static std::unique_ptr<OwnNetwork> network_;
    const double fault_s_ = setting("LUMENFARM_TEST_FAULT_SECONDS", 0);
    std::mt19937 random_{std::random_device{}()};
    std::vector<std::unique_ptr<Host>> hosts_;
    std::map<std::size_t, std::unique_ptr<Process>> workers_;
    std::uint64_t jobs_ = 0;
};
std::unique_ptr<OwnNetwork> FarmOnABadNetwork::network_;

TEST_F(FarmOnABadNetwork, PartitionsChangeNothing) {
    start_farm();
    for (int fault = 0; fault < faults(); ++fault) {
        SCOPED_TRACE(fault);
        const std::size_t host = fault % hosts_.size();
        const std::uint64_t before = lost_now();
        ASSERT_TRUE(hosts_[host]->cut());
        last(before);
        ASSERT_TRUE(hosts_[host]->mend());
        ASSERT_TRUE(until_worker_works(host));
        keep_busy();
    }
    expect_right_results();
    expect_noticed(counts(), faults());
}

TEST_F(FarmOnABadNetwork, WorkersThatStandStillChangeNothing) {
    start_farm();
    for (int fault = 0; fault < faults(); ++fault) {
        SCOPED_TRACE(fault);
        const std::size_t host = fault % hosts_.size();
        const std::uint64_t before = lost_now();
        workers_[host]->send(SIGSTOP);
        last(before);
        workers_[host]->send(SIGCONT);
        ASSERT_TRUE(until_worker_works(host));
        keep_busy();
    }
    expect_right_results();
    expect_noticed(counts(), faults());
}

/// The worker is killed while its cable is cut, so that the master's end stays open; every second time the cable is
/// mended before the master has noticed.
TEST_F(FarmOnABadNetwork, HalfOpenConnectionsChangeNothing) {
    start_farm();
    for (int fault = 0; fault < faults(); ++fault) {
        SCOPED_TRACE(fault);
        const std::size_t host = fault % hosts_.size();
        const std::uint64_t before = lost_now();
        ASSERT_TRUE(hosts_[host]->cut());
        workers_[host]->send(SIGKILL);
        EXPECT_EQ(workers_[host]->wait(), -SIGKILL) << workers_[host]->err();
        if (fault % 2 == 0) last(before);
        ASSERT_TRUE(hosts_[host]->mend());
        start_worker_on(host);
        ASSERT_TRUE(until_worker_works(host));
        keep_busy();
    }
    expect_right_results();
    expect_noticed(counts(), (faults() + 1) / 2);
}

}  // namespace
}  // namespace lumenfarm::testing
