#include "master/job_store.h"

#include "common/support/file.h"
#include "tests/scratch/folder.h"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>

namespace lumenfarm {
namespace {

namespace fs = std::filesystem;

class JobStoreFile : public ::testing::Test {
protected:
    fs::path file() const { return folder_ / "jobs.sqlite"; }
    JobStore open() const { return std::move(JobStore::open(file()).value()); }
    /// Changes the file as nobody should.
    void tamper(const char* sql) const { ASSERT_TRUE(Database::open(file(), versions)->execute(sql).has_value()); }

    static constexpr std::array versions{"-- 1", "-- 2"};

private:
    testing::Folder folder_;
};

JobRecord record_of(JobId job, wire::JobState state) {
    JobRecord record;
    record.key = 0xfedc'ba98'7654'3210 + job;
    record.spec.particles = 1'000 * job;
    record.status.job = job;
    record.status.state = state;
    record.status.name = "hall, north " + std::to_string(job);
    record.scene_bytes = 77;
    return record;
}

void expect_same(const JobRecord& a, const JobRecord& b) {
    EXPECT_EQ(a.key, b.key);
    EXPECT_EQ(a.spec, b.spec);
    EXPECT_EQ(a.status, b.status);
    EXPECT_EQ(a.scene_bytes, b.scene_bytes);
}

TEST_F(JobStoreFile, RecordsComeBackByNumber) {
    {
        JobStore store = open();
        for (const JobId job : {3u, 1u, 2u})
            ASSERT_TRUE(store.put(record_of(job, wire::JobState::running)).has_value());
        ASSERT_TRUE(store.put(record_of(2, wire::JobState::done)).has_value());
    }
    const auto contents = open().load();
    ASSERT_TRUE(contents.has_value());
    EXPECT_TRUE(contents->warnings.empty());
    ASSERT_EQ(contents->records.size(), 3u);
    expect_same(contents->records[0], record_of(1, wire::JobState::running));
    expect_same(contents->records[1], record_of(2, wire::JobState::done));
    expect_same(contents->records[2], record_of(3, wire::JobState::running));
}

TEST_F(JobStoreFile, WhatWasPutIsThereWithoutAnOrderlyEnd) {
    JobStore store = open();
    ASSERT_TRUE(store.put(record_of(1, wire::JobState::queued)).has_value());
    // as the next life would find it, had this one been killed here
    const fs::path copy = file().parent_path() / "copy.sqlite";
    fs::copy_file(file(), copy);
    fs::copy_file(file().string() + "-wal", copy.string() + "-wal");
    const auto contents = JobStore::open(copy)->load();
    ASSERT_TRUE(contents.has_value());
    ASSERT_EQ(contents->records.size(), 1u);
    expect_same(contents->records[0], record_of(1, wire::JobState::queued));
}

TEST_F(JobStoreFile, LivesAreCounted) {
    for (std::uint32_t life = 1; life <= 3; ++life) EXPECT_EQ(open().begin_life().value(), life);
}

TEST_F(JobStoreFile, ARecordThatWasChangedIsNamedAndLeftOut) {
    {
        JobStore store = open();
        for (const JobId job : {1u, 2u, 3u}) ASSERT_TRUE(store.put(record_of(job, wire::JobState::done)).has_value());
    }
    tamper("UPDATE jobs SET record = CAST(replace(CAST(record AS TEXT), 'north', 'south') AS BLOB) WHERE job = 2");
    tamper("UPDATE jobs SET job = 7 WHERE job = 3");
    const auto contents = open().load();
    ASSERT_TRUE(contents.has_value());
    ASSERT_EQ(contents->records.size(), 1u);
    EXPECT_EQ(contents->records[0].id(), 1u);
    ASSERT_EQ(contents->warnings.size(), 2u);
    EXPECT_EQ(contents->warnings[0], "the record of job 2 is damaged; it is left out");
    EXPECT_EQ(contents->warnings[1], "the record of job 7 is damaged; it is left out");
    EXPECT_EQ(contents->next_job, 8u) << "a new job must not overwrite it";
}

TEST_F(JobStoreFile, ARecordThatIsTooLargeIsNamedAndLeftOut) {
    ASSERT_TRUE(open().put(record_of(1, wire::JobState::done)).has_value());
    const std::string grow =
        "UPDATE jobs SET record = zeroblob(" + std::to_string(limits::job_record_bytes_max) + " + 1)";
    tamper(grow.c_str());
    const auto contents = open().load();
    ASSERT_TRUE(contents.has_value());
    EXPECT_TRUE(contents->records.empty());
    EXPECT_EQ(contents->warnings.size(), 1u);
}

TEST_F(JobStoreFile, AFlippedByteIsFoundOrWithoutEffect) {
    {
        JobStore store = open();
        ASSERT_EQ(store.begin_life().value(), 1u);
        for (const JobId job : {1u, 2u}) ASSERT_TRUE(store.put(record_of(job, wire::JobState::done)).has_value());
    }
    const std::vector<std::byte> whole = read_file(file(), 1u << 20).value();
    std::size_t refused = 0, named = 0;
    constexpr std::size_t step = 61;  // of bytes: coprime to the sizes of fields
    for (std::size_t at = 0; at < whole.size(); at += step) {
        std::vector<std::byte> damaged = whole;
        damaged[at] ^= std::byte{0x10};
        ASSERT_TRUE(write_file(file(), damaged).has_value());
        auto store = JobStore::open(file());
        auto contents = store ? store->load() : Result<JobStore::Contents>(store.error());
        if (!contents) {
            EXPECT_NE(contents.error().sentence.find("jobs.sqlite"), std::string::npos);
            ++refused;
            continue;
        }
        named += contents->warnings.size();
        ASSERT_EQ(contents->records.size() + contents->warnings.size(), 2u) << "byte " << at;
        for (const JobRecord& record : contents->records)
            expect_same(record, record_of(record.id(), wire::JobState::done));
        const auto life = store->begin_life();
        EXPECT_EQ(life ? *life : 2u, 2u) << "byte " << at;
    }
    EXPECT_GT(refused, 0u);
    EXPECT_GT(named, 0u);
}

TEST_F(JobStoreFile, OtherFilesAreRefused) {
    ASSERT_TRUE(write_file(file(), std::string(5'000, 'x')).has_value());
    const auto store = JobStore::open(file());
    ASSERT_FALSE(store.has_value());
    EXPECT_EQ(store.error().sentence, "the database '" + file().string() + "' fails: file is not a database");
}

TEST_F(JobStoreFile, NewerVersionsAreRefused) {
    (void)open();
    tamper("PRAGMA user_version = 9");
    const auto store = JobStore::open(file());
    ASSERT_FALSE(store.has_value());
    EXPECT_NE(store.error().sentence.find("newer than this program knows"), std::string::npos);
}

}  // namespace
}  // namespace lumenfarm
