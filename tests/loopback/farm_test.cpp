#include "common/solution/run_folder.h"
#include "tests/loopback/farm_fixture.h"
#include "tests/solution/traced_run.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

/// A farm of real processes, started as a user would.
namespace lumenfarm::testing {
namespace {

bool merged_something(const wire::WorkerStatus& worker) { return worker.particles > 0; }

TEST_F(Farm, FetchedResultIsThatOfRun) {
    start_master();
    const auto first = start_worker("first");
    const auto second = start_worker("second");
    const std::string submitted =
        lumenfarm({"submit", scene_, "--particles", "200k", "--keep-hits", "1k", "--wait", "--master", address_});
    const std::string fetched = lumenfarm({"fetch", "1", "-o", path("fetched"), "--master", address_});
    const std::string ran = lumenfarm({"run", scene_, "--particles", "200k", "--keep-hits", "1k", "-o", path("ran")});

    const std::string digest = line_after(ran, "digest ");
    EXPECT_EQ(digest.size(), 64u);
    EXPECT_EQ(line_after(submitted, "digest "), digest);
    EXPECT_EQ(line_after(fetched, "digest "), digest);
    const auto report = json({"inspect", path("fetched"), "--json"});
    EXPECT_EQ(report.at("digest").as_string(), digest);
    EXPECT_TRUE(report.at("balance").at("ticks_equal").as_bool());
    EXPECT_EQ(report.at("particles").to_number<std::uint64_t>(), 200'000u);
    // the name of what was submitted, and the job as scripts see it
    const auto job = json({"status", "1", "--json", "--master", address_});
    EXPECT_EQ(job.at("name").as_string(), "mixed");
    EXPECT_EQ(job.at("state").as_string(), "done");
    EXPECT_EQ(job.at("digest").as_string(), digest);
    EXPECT_EQ(json({"workers", "--json", "--master", address_}).at("workers").as_array().size(), 2u);
    for (const char* name : {"solution.lfs", "scene.lfscene", "report.json"})
        EXPECT_TRUE(std::filesystem::exists(folder_ / "ran" / name)) << name;
    // no camera in the scene: one framing it
    EXPECT_NE(ran.find(".png"), std::string::npos);
    EXPECT_NE(ran.find(".exr"), std::string::npos);
}

TEST_F(Farm, WorkersThatComeAndGoChangeNothing) {
    start_master();
    const auto first = start_worker("first");
    // records: results come often, so that the middle of the job is long
    ASSERT_EQ(lumenfarm({"submit", scene_, "--particles", "2M", "--particles-per-set", "2000", "--packing", "records",
                         "--master", address_}),
              "1\n");

    // a worker that starts in the middle helps: the first stands still until it has
    ASSERT_TRUE(until_worker("first", merged_something));
    first->send(SIGSTOP);
    ASSERT_TRUE(until_job(1, [](const wire::JobStatus& job) { return job.state == wire::JobState::running; }));
    const auto second = start_worker("second");
    ASSERT_TRUE(until_worker("second", merged_something));
    first->send(SIGCONT);

    // a worker that is stopped in the middle hands back what it has
    second->send(SIGTERM);
    EXPECT_EQ(second->wait(), 0) << second->err();
    ASSERT_TRUE(until_job(1, [](const wire::JobStatus& job) { return job.state == wire::JobState::done; }));
    const auto job = json({"status", "1", "--json", "--master", address_});
    EXPECT_EQ(job.at("leases_expired").to_number<std::uint64_t>(), 0u);
    EXPECT_EQ(job.at("committed").to_number<std::uint64_t>(), 2'000'000u);

    JobSpec spec;
    spec.particles = 2'000'000;
    EXPECT_EQ(job.at("digest").as_string(), solution_digest(test::traced_run(mixed_room(), spec).solution).hex());
    first->send(SIGTERM);
    EXPECT_EQ(first->wait(), 0) << first->err();
}

TEST_F(Farm, CancelledJobKeepsWhatIsDone) {
    start_master();
    const auto worker = start_worker("only");
    ASSERT_EQ(lumenfarm({"submit", scene_, "--particles", "4G", "--name", "long", "--master", address_}), "1\n");
    ASSERT_TRUE(until_job(1, [](const wire::JobStatus& job) { return job.committed > 0; }));
    EXPECT_EQ(lumenfarm({"cancel", "1", "--master", address_}), "job 1 is cancelled\n");
    lumenfarm({"watch", "1", "--master", address_}, 3);
    lumenfarm({"fetch", "1", "-o", path("fetched"), "--master", address_});
    const auto report = json({"inspect", path("fetched"), "--json"});
    EXPECT_FALSE(report.at("complete").as_bool());
    EXPECT_GT(report.at("particles").to_number<std::uint64_t>(), 0u);
    EXPECT_TRUE(report.at("balance").at("ticks_equal").as_bool());
}

/// The files of a folder, none of them half-written.
std::vector<std::string> files_in(const std::filesystem::path& folder) {
    std::vector<std::string> names;
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
        names.push_back(entry.path().filename());
        EXPECT_EQ(names.back().find(".part"), std::string::npos);
    }
    return names;
}

TEST_F(Farm, InterruptedRunKeepsWhatIsDone) {
    const auto run = start("lumenfarm", {"run", scene_, "--particles", "4G", "-o", path("out")});
    // progress that is not zero
    ASSERT_TRUE(run->read_until([&] { return run->err().find("left") != std::string::npos; })) << run->err();
    run->send(SIGINT);
    EXPECT_EQ(run->wait(), 3) << run->err();
    EXPECT_NE(run->err().find("interrupted after "), std::string::npos) << run->err();

    const auto report = json({"inspect", path("out"), "--json"});
    EXPECT_FALSE(report.at("complete").as_bool());
    EXPECT_GT(report.at("particles").to_number<std::uint64_t>(), 0u);
    EXPECT_TRUE(report.at("balance").at("ticks_equal").as_bool());
    EXPECT_EQ(line_after(run->out(), "digest "), report.at("digest").as_string());
    EXPECT_TRUE(std::filesystem::exists(folder_ / "out/report.json"));
    files_in(folder_ / "out");
    lumenfarm({"render", path("out"), "--look-from", "0.5,0.5,0.95", "--look-at", "0.5,0.5,0", "--size", "32x24", "-o",
               path("view.exr")});
    EXPECT_TRUE(std::filesystem::exists(folder_ / "view.exr"));
    EXPECT_TRUE(std::filesystem::exists(folder_ / "view.png"));
}

TEST_F(Farm, SecondInterruptEndsAtOnceAndLeavesNothingHalfWritten) {
    const auto temporary = folder_ / "tmp";
    std::filesystem::create_directory(temporary);
    Process run({program("lumenfarm"), "run", scene_, "--particles", "4G", "-o", path("out")},
                {"HOME=" + path(""), "TMPDIR=" + temporary.string()});
    ASSERT_TRUE(run.read_until([&] { return run.err().find("particles") != std::string::npos; })) << run.err();
    run.send(SIGTERM);
    ASSERT_TRUE(run.read_until([&] { return run.err().find("stopping") != std::string::npos; })) << run.err();
    run.send(SIGTERM);
    EXPECT_EQ(run.wait(), 3) << run.err();
    for (const auto& name : files_in(folder_ / "out"))
        EXPECT_TRUE(name == "solution.lfs" || name == "scene.lfscene" || name == "report.json") << name;
}

}  // namespace
}  // namespace lumenfarm::testing
