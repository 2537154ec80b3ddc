#include "tests/loopback/farm_fixture.h"
#include "tests/loopback/notify_socket.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <utility>

/// Daemons as systemd sees them.
namespace lumenfarm::testing {
namespace {

class FarmUnderSystemd : public Farm {
protected:
    void submit(const std::string& particles) {
        ASSERT_EQ(lumenfarm({"submit", scene_, "--particles", particles, "--particles-per-set", "20k", "--packing",
                             "records", "--master", address_}),
                  "1\n");
    }
    /// A master with a job, whose disk calls are tampered with as strace's `fault` says.
    void start_master_with_job_and(const std::string& fault) {
        start_master();
        submit("4G");
        kill_master();
        const std::string call = fault.substr(0, fault.find(':'));
        launch_master({}, {"strace", "-D", "-f", "-o", "/dev/null", "-e", "trace=" + call, "-e", "inject=" + fault},
                      of_master_.environment());
        ASSERT_TRUE(master_listens()) << master_->err();
        std::ifstream status("/proc/" + std::to_string(master_->id()) + "/status");
        for (std::string line; std::getline(status, line);)
            if (line.starts_with("TracerPid:")) tracer_ = std::stoi(line.substr(10));
        ASSERT_GT(tracer_, 0);
    }
    static void expect_orderly_end(Process& daemon, NotifySocket& notified) {
        daemon.send(SIGTERM);
        EXPECT_TRUE(notified.listen_until([&] { return notified.has("STOPPING=1"); }));
        notified.close();
        EXPECT_EQ(daemon.wait(), 0) << daemon.err();
    }
    /// A tracer that delays a call outlives its program, and holds its streams.
    ~FarmUnderSystemd() override { end_tracer(); }
    void end_tracer() {
        if (tracer_ > 0) ::kill(std::exchange(tracer_, 0), SIGKILL);
    }

    pid_t tracer_ = 0;
    NotifySocket of_master_{path("notify-master")};
};

TEST_F(FarmUnderSystemd, DaemonsSayThatTheyAreReadyWhatTheyDoAndThatTheyEnd) {
    launch_master({}, {}, of_master_.environment());
    ASSERT_TRUE(of_master_.listen_until([&] { return of_master_.has("READY=1"); }));
    ASSERT_TRUE(master_listens());
    EXPECT_TRUE(of_master_.listen_until([&] { return of_master_.said("no job runs; no workers"); }));

    NotifySocket of_worker(path("notify-worker"));
    const auto worker = start("lumenfarm-worker", {"--master", address_, "--threads", "1", "--cache", path("cache")},
                              of_worker.environment());
    ASSERT_TRUE(of_worker.listen_until([&] { return of_worker.has("READY=1"); }));
    submit("4G");
    EXPECT_TRUE(of_master_.listen_until([&] { return of_master_.said("job 1 at 0 %; 1 worker with 1 thread"); }));
    const std::string connected = "connected to " + address_ + "; traces job 1 on 1 of 1 threads";
    EXPECT_TRUE(of_worker.listen_until([&] { return of_worker.said(connected); }));

    // both are busy, and answer again and again
    of_master_.forget();
    of_worker.forget();
    EXPECT_TRUE(of_master_.listen_until([&] { return of_master_.count("WATCHDOG=1") >= 3; }));
    EXPECT_TRUE(of_worker.listen_until([&] { return of_worker.count("WATCHDOG=1") >= 3; }));

    expect_orderly_end(*worker, of_worker);
    expect_orderly_end(*master_, of_master_);
}

TEST_F(FarmUnderSystemd, ADiskThatHangsStopsThePingsThoughTheMasterStillAnswers) {
    if (!can_inject()) GTEST_SKIP() << "strace can't be used here";
    start_master_with_job_and("fdatasync:delay_enter=1000000000:when=20+");
    ASSERT_TRUE(of_master_.listen_until([&] { return of_master_.has("WATCHDOG=1"); }));
    const auto worker = start_worker("only");
    ASSERT_TRUE(of_master_.listen_until([&] { return of_master_.said("the disk does not answer"); }));
    // it goes on serving, for some times as long as there is between two pings; a disk that was merely slow comes first
    bool silent = false;
    for (int look = 0; look < 20 && !silent; ++look) {
        of_master_.listen_now();
        of_master_.forget();
        int answers = 0;
        ASSERT_TRUE(until_job(1, [&](const wire::JobStatus&) { return ++answers == 50; }));
        of_master_.listen_now();
        silent = !of_master_.has("WATCHDOG=1");
    }
    EXPECT_TRUE(silent);
    EXPECT_NE((master_->read_now(), master_->err()).find("the disk does not answer"), std::string::npos);

    // and ends at once when it is told twice
    master_->send(SIGTERM);
    ASSERT_TRUE(of_master_.listen_until([&] { return of_master_.has("STOPPING=1"); }));
    master_->send(SIGTERM);
    EXPECT_TRUE(master_->read_until([&] {
        return master_->err().find("again: the master ends at once") != std::string::npos;
    })) << master_->err();
    end_tracer();
    EXPECT_EQ(master_->wait(), 0) << master_->err();
}

TEST_F(FarmUnderSystemd, ADiskThatIsSlowIsWaitedFor) {
    if (!can_inject()) GTEST_SKIP() << "strace can't be used here";
    start_master_with_job_and("fdatasync:delay_enter=2000000:when=20");
    const auto worker = start_worker("only");
    ASSERT_TRUE(of_master_.listen_until([&] { return of_master_.said("the disk does not answer"); }));
    of_master_.forget();
    EXPECT_TRUE(of_master_.listen_until([&] { return of_master_.has("WATCHDOG=1"); }));
    EXPECT_TRUE(until_job(1, [](const wire::JobStatus& job) { return job.committed > 1'000'000; }));
}

}  // namespace
}  // namespace lumenfarm::testing
