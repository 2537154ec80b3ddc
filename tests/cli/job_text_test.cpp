#include "cli/job_text.h"

#include <gtest/gtest.h>
#include <boost/json.hpp>

namespace lumenfarm {
namespace {

wire::JobStatus running_job() {
    wire::JobStatus job;
    job.job = 3;
    job.name = "cornell";
    job.state = wire::JobState::running;
    job.particles = 20'000'000;
    job.committed = 12'345'678;
    job.workers = 2;
    job.particles_per_second = 1'214'000;
    job.eta_seconds = 6.3;
    return job;
}

TEST(ProgressLine, SaysHowFarHowFastAndHowLong) {
    EXPECT_EQ(progress_line(running_job()), "cornell: 12.3M of 20M particles (61 %), 1.21M/s, 6.3 s left");
}

TEST(ProgressLine, NeverSays100PercentBeforeTheEnd) {
    auto job = running_job();
    job.committed = job.particles - 1;
    EXPECT_NE(progress_line(job).find("(99 %)"), std::string::npos);
}

TEST(ProgressLine, SaysThatNobodyIsAtIt) {
    auto job = running_job();
    job.workers = 0;
    job.particles_per_second = 0;
    job.eta_seconds.reset();
    EXPECT_EQ(progress_line(job), "cornell: 12.3M of 20M particles (61 %), no worker is at it");
}

TEST(ProgressLine, NamesTheJobByNumberWhenItHasNoName) {
    auto job = running_job();
    job.name.clear();
    job.state = wire::JobState::queued;
    EXPECT_EQ(progress_line(job), "job 3: queued");
}

TEST(Duration, IsShortAndReadable) {
    EXPECT_EQ(duration_text(0.04), "0.0 s");
    EXPECT_EQ(duration_text(9.94), "9.9 s");
    EXPECT_EQ(duration_text(9.97), "10 s");
    EXPECT_EQ(duration_text(59.4), "59 s");
    EXPECT_EQ(duration_text(200), "3 min 20 s");
    EXPECT_EQ(duration_text(7'500), "2 h 5 min");
    EXPECT_EQ(duration_text(300'000), "3 days");
}

TEST(JobTables, HostileNamesStayOnTheirLine) {
    auto job = running_job();
    job.name = "a\nb\x1b[2Jc";
    const std::vector<wire::JobStatus> jobs{job};
    const std::string table = jobs_table(jobs);
    EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 2);
    EXPECT_EQ(table.find('\x1b'), std::string::npos);
}

TEST(JobDocument, UnknownsAreNull) {
    const auto running = job_document(running_job());
    EXPECT_TRUE(running.at("digest").is_null());
    EXPECT_EQ(running.at("committed").to_number<std::uint64_t>(), 12'345'678u);
    EXPECT_EQ(running.at("state").as_string(), "running");
    auto done = running_job();
    done.state = wire::JobState::done;
    done.eta_seconds.reset();
    done.digest = Digest{};
    EXPECT_EQ(job_document(done).at("digest").as_string().size(), 64u);
    EXPECT_TRUE(job_document(done).at("eta_s").is_null());
}

TEST(Counts, PeopleSeeWhatHasComeUpAndScriptsSeeAll) {
    const std::vector<wire::ReasonCount> counts = {
        {"sent_off", "farm_full", 0}, {"sent_off", "replaced", 2}, {"dropped", "chunk_refused", 0}};
    EXPECT_EQ(counts_text(counts), "sent_off            replaced 2\n");
    EXPECT_EQ(counts_text({}), "");
    const auto document = counts_document(counts);
    EXPECT_EQ(document.at("sent_off").at("replaced").to_number<std::uint64_t>(), 2u);
    EXPECT_EQ(document.at("dropped").at("chunk_refused").to_number<std::uint64_t>(), 0u);
}

TEST(WorkersTable, SaysThatThereAreNone) {
    EXPECT_EQ(workers_table({}), "no workers\n");
    EXPECT_EQ(jobs_table({}), "no jobs\n");
}

}  // namespace
}  // namespace lumenfarm
