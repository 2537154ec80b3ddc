#include "tests/simulation/simulated_disk.h"
#include "tests/simulation/simulated_vfs.h"
#include "tests/simulation/small_job.h"

#include <gtest/gtest.h>

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

class StorageRoom : public ::testing::Test {
protected:
    void begin() {
        ASSERT_TRUE(rows_.make_folder("/storage").has_value());
        const SnapshotRule only_for_room{1'000'000, 1'000'000, std::uint64_t{1} << 40};
        storage_ = std::move(Storage::open(disk_, "/storage", vfs_.name(), only_for_room).value());
        job_.begin(*storage_);
    }
    bool commit(std::uint64_t number) { return storage_->commit({{job_.stored(number)}, {}}).has_value(); }
    std::uint64_t in_segments() {
        std::uint64_t bytes = 0;
        for (const std::string& name : disk_.list("/storage/segments").value())
            bytes += disk_.open("/storage/segments/" + name, DiskOpen::existing).value()->size().value();
        return bytes;
    }
    Digest solution() { return storage_->store(StoreSolution{job_.record, {}}).value().status.digest.value(); }

    SmallJob job_;
    SimulatedDisk disk_;
    SimulatedDisk rows_;  ///< the database is larger than so few results
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
