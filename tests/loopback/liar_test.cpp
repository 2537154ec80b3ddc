#include "tests/loopback/farm_fixture.h"
#include "tests/solution/traced_run.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <ostream>
#include <string>

/// A worker of which some results are wrong, in a farm that traces a part of its results again.
/// LUMENFARM_TEST_RARE_LIES: 5 % wrong and 2 % audited, in a job long enough to find it; by default ten times as much
/// each, in a short one.
namespace lumenfarm::testing {
namespace {

struct Lies {
    std::string wrong, audited;
    std::uint64_t particles;
};

Lies wanted_lies() {
    // each result betrays the liar with 0.1 or 0.001, and it has a third of 4,000 or of 100,000 of them
    return std::getenv("LUMENFARM_TEST_RARE_LIES") ? Lies{"0.05", "0.02", 50'000'000} : Lies{"0.5", "0.2", 2'000'000};
}

struct Telling {
    std::string packing;
    bool possible;  ///< what it says could be
    friend void PrintTo(const Telling& telling, std::ostream* out) {
        *out << telling.packing << (telling.possible ? ", possible" : ", any bit");
    }
};

class FarmWithALiar : public Farm, public ::testing::WithParamInterface<Telling> {
protected:
    std::unique_ptr<Process> start_liar(const std::string& wrong) const {
        std::vector<std::string> options{
            "--normal-priority", "--master",         address_, "--threads", "1", "--name", "liar",
            "--cache",           path("cache-liar"), "--lies", wrong};
        if (!GetParam().possible) options.emplace_back("--impossible");
        return start("lying-worker", options);
    }
};

TEST_P(FarmWithALiar, FindsItKeepsItOutAndTracesItsSetsAgain) {
    const Lies lies = wanted_lies();
    start_master({"--audit-fraction", lies.audited});
    const auto liar = start_liar(lies.wrong), first = start_worker("first"), second = start_worker("second");
    const auto begun = Clock::now();
    ASSERT_EQ(lumenfarm({"submit", scene_, "--particles", std::to_string(lies.particles), "--particles-per-set", "500",
                         "--packing", GetParam().packing, "--master", address_}),
              "1\n");
    const auto found = [](const wire::JobStatus& job) { return job.liars > 0; };
    while (!until_job(1, found) && Clock::now() < begun + std::chrono::minutes(10)) {
    }
    RecordProperty("found_after_seconds", std::to_string(std::chrono::duration<double>(Clock::now() - begun).count()));
    EXPECT_EQ(liar->wait(), 1);
    const std::string why =
        GetParam().possible ? "two other machines contradict what this one has traced for job 1" : "";
    EXPECT_NE(liar->err().find(why + ": look at its memory"), std::string::npos) << liar->err();

    const auto again = start_liar(lies.wrong);
    EXPECT_EQ(again->wait(), 1) << "it is known by its name and its address";
    EXPECT_NE(again->err().find("is kept out until the master starts again"), std::string::npos) << again->err();

    const auto done = [](const wire::JobStatus& job) { return job.state == wire::JobState::done; };
    while (!until_job(1, done) && Clock::now() < begun + std::chrono::minutes(20)) {
    }
    const auto status = json({"status", "1", "--json", "--master", address_});
    JobSpec spec;
    spec.particles = lies.particles;
    EXPECT_EQ(status.at("digest").as_string(), solution_digest(test::traced_run(mixed_room(), spec).solution).hex());
    EXPECT_EQ(status.at("liars").to_number<int>(), 1);
    EXPECT_TRUE(until_farm([](const wire::StatusReply& farm) {
        return counted(farm, "sent_off", {"quarantined", "lied"}) == 2;
    }));
    for (const char* honest : {"first", "second"})
        EXPECT_TRUE(until_worker(honest, [](const wire::WorkerStatus&) { return true; })) << honest;
}

INSTANTIATE_TEST_SUITE_P(Tellings, FarmWithALiar,
                         ::testing::Values(Telling{"records", true}, Telling{"maps", true}, Telling{"records", false}),
                         [](const auto& telling) {
                             return telling.param.packing + (telling.param.possible ? "Possible" : "AnyBit");
                         });

}  // namespace
}  // namespace lumenfarm::testing
