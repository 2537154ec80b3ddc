#include "tests/simulation/simulated_disk.h"
#include "tests/simulation/simulated_vfs.h"
#include "tests/simulation/small_job.h"

#include <gtest/gtest.h>

#include <limits>
#include <numeric>

/// A master's storage on a disk that has little room.
namespace lumenfarm::testing {
namespace {

constexpr std::uint64_t results = 50;  ///< all that the job has of this light
const StoreSnapshot routine{1, {}}, at_the_end{1, {}, true};

std::vector<std::uint64_t> first(std::uint64_t count) {
    std::vector<std::uint64_t> numbers(count);
    std::iota(numbers.begin(), numbers.end(), 0u);
    return numbers;
}

/// Its snapshots are for room only. `rows`: for the database, which is larger than so few results.
std::unique_ptr<Storage> storage_with(SimulatedDisk& disk, SimulatedDisk& rows, const SimulatedVfs& vfs) {
    EXPECT_TRUE(rows.make_folder("/storage").has_value());
    const SnapshotRule only_for_room{1'000'000, 1'000'000, std::uint64_t{1} << 40};
    return std::move(Storage::open(disk, "/storage", vfs.name(), only_for_room).value());
}

std::uint64_t bytes_in(SimulatedDisk& disk, const std::string& folder) {
    std::uint64_t bytes = 0;
    for (const std::string& name : disk.list(folder).value())
        bytes += disk.open(folder + "/" + name, DiskOpen::existing).value()->size().value();
    return bytes;
}

class StorageRoom : public ::testing::Test {
protected:
    void begin() {
        storage_ = storage_with(disk_, rows_, vfs_);
        job_.begin(*storage_);
    }
    bool commit(std::uint64_t number) { return storage_->commit({{job_.stored(number)}, {}}).has_value(); }
    std::uint64_t in_segments() { return bytes_in(disk_, "/storage/segments"); }
    Digest solution() { return storage_->store(StoreSolution{job_.record, {}}).value().status.digest.value(); }

    SmallJob job_;
    SimulatedDisk disk_, rows_;
    const SimulatedVfs vfs_{rows_};
    std::unique_ptr<Storage> storage_;
};

TEST_F(StorageRoom, ASnapshotMakesRoomBeforeResultsFillTheDisk) {
    begin();
    ASSERT_TRUE(commit(0));
    const std::uint64_t bytes_of_a_result = in_segments();
    const std::uint64_t sum_bytes = JobSums(job_.record.spec, job_.prepared).bytes();
    disk_.set_capacity(disk_.used() + 4 * sum_bytes + 4 * bytes_of_a_result);
    int snapshots = 0;
    std::uint64_t number = 1;
    for (; number < results && commit(number); ++number) snapshots += storage_->store(routine).value();
    EXPECT_EQ(number, results);
    EXPECT_GT(snapshots, 1);
    EXPECT_EQ(solution(), job_.sums_of(first(results)));
}

TEST(StorageRoomForSums, FewerResultsThanTheSumsHaveBytesMakeRoomOnceThereIsASnapshot) {
    const SmallJob job(Strategy::sets, 0.2);
    SimulatedDisk disk, rows;
    const SimulatedVfs vfs(rows);
    const auto storage = storage_with(disk, rows, vfs);
    job.begin(*storage);
    const auto commit = [&](std::uint64_t number) { return storage->commit({{job.stored(number)}, {}}).has_value(); };
    ASSERT_TRUE(commit(0));
    const std::uint64_t bytes_of_a_result = bytes_in(disk, "/storage/segments");
    ASSERT_LT(10 * bytes_of_a_result, JobSums(job.record.spec, job.prepared).bytes());
    ASSERT_TRUE(storage->store(at_the_end).value());
    disk.set_capacity(disk.used() + 20 * bytes_of_a_result);
    std::uint64_t number = 1;
    for (; number < results && commit(number); ++number) (void)storage->store(routine).value();
    EXPECT_EQ(number, results);
    disk.set_capacity(std::numeric_limits<std::uint64_t>::max());
    EXPECT_EQ(storage->store(StoreSolution{job.record, {}}).value().status.digest, job.sums_of(first(results)));
}

TEST_F(StorageRoom, ASnapshotThatFoundNoRoomWaitsForAsMuch) {
    begin();
    for (std::uint64_t number = 0; number < 8; ++number) ASSERT_TRUE(commit(number));
    const StoreSnapshot with_a_full_disk{1, {}, false, true};
    const std::uint64_t full = disk_.used();
    disk_.set_capacity(full + 100);
    EXPECT_EQ(storage_->store(with_a_full_disk).error().code, ErrorCode::no_space);
    EXPECT_EQ(disk_.used(), full);
    EXPECT_FALSE(storage_->store(with_a_full_disk).value()) << "it would not fit";
    disk_.set_capacity(full + 100'000);
    EXPECT_TRUE(storage_->store(with_a_full_disk).value());
    EXPECT_EQ(in_segments(), 0u);
}

TEST(StorageRoomForRows, ASnapshotThatIsWrittenAgainAndHasNoRowYetIsNotRemoved) {
    const SmallJob job(Strategy::subspaces);
    SimulatedDisk disk, rows;
    const SimulatedVfs vfs(rows);
    auto storage = storage_with(disk, rows, vfs);
    job.begin(*storage);
    ASSERT_TRUE(storage->commit({{job.stored(0)}, {}}).has_value());
    ASSERT_TRUE(storage->store(at_the_end).value());
    ASSERT_TRUE(storage->commit({{job.stored(1)}, {}}).has_value());
    const std::string segment = disk.list("/storage/segments").value().at(0);
    ASSERT_TRUE(disk.open("/storage/segments/" + segment, DiskOpen::existing).value()->truncate(9).has_value());
    storage.reset();

    storage = storage_with(disk, rows, vfs);
    const auto start = storage->start();
    ASSERT_TRUE(start.has_value());
    rows.set_capacity(rows.used());
    const auto refused = storage->prepare({start->records.front()});
    ASSERT_FALSE(refused.has_value()) << "the result that is lost may not be found again";
    EXPECT_EQ(refused.error().code, ErrorCode::no_space);
    rows.set_capacity(std::numeric_limits<std::uint64_t>::max());
    const auto recovered = storage->prepare({start->records.front()});
    ASSERT_TRUE(recovered.has_value());
    ASSERT_EQ(recovered->damages.size(), 1u);
    EXPECT_NE(recovered->damages[0].find("result 1 of job 1 is lost"), std::string::npos) << recovered->damages[0];
    EXPECT_EQ(storage->store(StoreSolution{start->records.front(), {}}).value().status.digest, job.sums_of({0}));
}

TEST_F(StorageRoom, WhatWasRetractedTakesNoRoom) {
    begin();
    for (std::uint64_t number = 0; number < 4; ++number) ASSERT_TRUE(commit(number));
    ASSERT_GT(in_segments(), 0u);
    ASSERT_TRUE(storage_->retract({job_.record, {}, true}).has_value());
    EXPECT_EQ(in_segments(), 0u);
    ASSERT_TRUE(commit(0));
    EXPECT_EQ(solution(), job_.sums_of({0}));
}

TEST_F(StorageRoom, SnapshotsThatMakeNoRoomAreNotMadeForIt) {
    job_.record.audited = true;
    begin();
    ASSERT_TRUE(commit(0));
    disk_.set_capacity(disk_.used() + 20 * in_segments());
    std::uint64_t number = 1;
    for (; number < results && commit(number); ++number) EXPECT_FALSE(storage_->store(routine).value());
    EXPECT_LT(number, results) << "the disk is full";
}

TEST_F(StorageRoom, WhatWasRecoveredInPartMakesNoSnapshot) {
    job_.record.audited = true;
    begin();
    for (std::uint64_t number = 0; number < 4; ++number) ASSERT_TRUE(commit(number));
    disk_.fail_open_at(3);
    const Retract retract{job_.record, {SmallJob::machine + 1}, false};
    const auto refused = storage_->retract(retract);
    ASSERT_FALSE(refused.has_value());
    EXPECT_EQ(refused.error().code, ErrorCode::no_space);
    EXPECT_FALSE(storage_->store(at_the_end).value());
    ASSERT_TRUE(storage_->retract(retract).has_value());
    EXPECT_TRUE(storage_->store(at_the_end).value());
    EXPECT_EQ(solution(), job_.sums_of(first(4)));
}

}  // namespace
}  // namespace lumenfarm::testing
