// What the database has acknowledged outlives the power, wherever it fails.
#include "master/disk/database.h"
#include "tests/simulation/simulated_disk.h"
#include "tests/simulation/simulated_vfs.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace lumenfarm::testing {
namespace {

constexpr std::array schema{
    "CREATE TABLE pages (batch INTEGER NOT NULL, page INTEGER NOT NULL, bytes BLOB NOT NULL,"
    " PRIMARY KEY (batch, page)) STRICT"};
constexpr const char* file = "/storage/jobs.sqlite";
constexpr std::uint64_t pages_per_batch = 3;

std::vector<std::byte> page_of(std::uint64_t batch, std::uint64_t page) {
    return std::vector<std::byte>(2'000, static_cast<std::byte>(7 * batch + page));
}

/// A transaction.
Result<void> put_batch(Database& database, std::uint64_t batch) {
    auto all = database.begin();
    if (!all) return all.error();
    for (std::uint64_t page = 0; page < pages_per_batch; ++page) {
        auto put = database.prepare("INSERT INTO pages VALUES (?, ?, ?)");
        if (!put) return put.error();
        const auto bytes = page_of(batch, page);
        if (const auto done = put->bind(batch).bind(page).bind(bytes).run(); !done) return done;
    }
    return all->commit();
}

/// Pages of each batch.
std::map<std::uint64_t, std::uint64_t> batches_in(Database& database) {
    std::map<std::uint64_t, std::uint64_t> found;
    Statement rows = std::move(database.prepare("SELECT batch, page, bytes FROM pages").value());
    while (rows.step().value()) {
        EXPECT_EQ(rows.bytes(2), page_of(rows.number(0), rows.number(1)));
        ++found[rows.number(0)];
    }
    return found;
}

struct Storage {
    explicit Storage(std::uint64_t seed = 1) : disk(seed) { (void)disk.make_folder("/storage"); }

    Result<Database> open() {
        auto database = Database::open(file, schema, vfs.name());
        if (!database) return database;
        // often, so that accidents happen while the log is moved into the database, too
        database->limit_log(12);
        return database;
    }

    SimulatedDisk disk;
    SimulatedVfs vfs{disk};
};

/// A database over many lives, and what it has acknowledged.
class Lives {
public:
    explicit Lives(std::uint64_t seed) : storage_(seed), random_(seed) {}

    SimulatedDisk& disk() { return storage_.disk; }
    /// Opens it, checks it and puts batches, until one fails. Then the program closes it, or is killed.
    void live(std::uint64_t batches, bool killed = false) {
        auto database = storage_.open();
        if (!database) return end_with(database.error());
        check(*database);
        for (std::uint64_t i = 0; i < batches; ++i) {
            if (const auto put = put_batch(*database, ++begun_); !put) {
                end_with(put.error());
                break;
            }
            acknowledged_.insert(begun_);
        }
        if (killed) disk().power_off();
    }
    void crash() { disk().crash(random_); }
    std::uint64_t below(std::uint64_t bound) { return random_() % bound; }
    /// A life without accidents, and what a power cut leaves of it.
    void settle() {
        disk().fail_sometimes({});
        for (int life = 0; life < 2; ++life) {
            const auto before = acknowledged_.size();
            live(2);
            EXPECT_GE(acknowledged_.size(), before + 2) << last_error_;
            crash();
        }
    }
    std::uint64_t surprises() const { return surprises_; }

private:
    /// Every acknowledged batch is there, and none in part; one whose commit was not answered may be.
    void check(Database& database) {
        const auto found = batches_in(database);
        for (const std::uint64_t batch : acknowledged_) EXPECT_TRUE(found.contains(batch)) << batch << " is lost";
        for (const auto& [batch, pages] : found) {
            EXPECT_EQ(pages, pages_per_batch) << batch << " is there in part";
            surprises_ += acknowledged_.insert(batch).second ? 1 : 0;
        }
    }

    void end_with(const Error& error) { last_error_ = error.sentence; }

    Storage storage_;
    std::mt19937_64 random_;
    std::uint64_t begun_ = 0;
    std::set<std::uint64_t> acknowledged_;
    std::string last_error_;
    std::uint64_t surprises_ = 0;  ///< batches that are there though their commit was not answered
};

TEST(DatabaseOnSimulatedDisk, NothingAcknowledgedIsLostWhereverThePowerFails) {
    std::uint64_t surprises = 0;
    std::uint64_t calls = 0;
    for (bool reached = true; reached; ++calls) {
        for (std::uint64_t seed = 1; seed <= 4; ++seed) {
            SCOPED_TRACE("the power fails at call " + std::to_string(calls + 1) + ", seed " + std::to_string(seed));
            Lives lives(seed);
            lives.disk().crash_at(calls + 1);
            lives.live(8);
            reached = !lives.disk().has_power();
            lives.crash();
            lives.settle();
            surprises += lives.surprises();
            if (::testing::Test::HasFailure()) return;
        }
    }
    EXPECT_GT(calls, 100u);
    EXPECT_GT(surprises, 0u) << "a commit that was under way may last";
}

TEST(DatabaseOnSimulatedDisk, ThePowerFailsAgainAndAgain) {
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Lives lives(seed);
        for (int life = 0; life < 15; ++life) {
            lives.disk().crash_at(1 + lives.below(150));
            lives.live(8);
            lives.crash();
        }
        lives.settle();
        if (::testing::Test::HasFailure()) return;
    }
}

TEST(DatabaseOnSimulatedDisk, SyncsFailAndThePowerToo) {
    for (std::uint64_t seed = 1; seed <= 400; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Lives lives(seed);
        for (int life = 0; life < 20; ++life) {
            lives.disk().fail_sometimes({.sync = life % 2 == 0 ? 0.3 : 0});
            lives.disk().crash_at(1 + lives.below(60));
            lives.live(4, lives.below(2) == 0);
            if (lives.below(2) == 0) lives.crash();
            lives.disk().kill();
        }
        lives.settle();
        if (::testing::Test::HasFailure()) return;
    }
}

TEST(DatabaseOnSimulatedDisk, AFullDiskLosesNothingAndCanBeUsedWhenThereIsRoomAgain) {
    for (std::uint64_t room = 0; room < 100'000; room += 3'000) {
        SCOPED_TRACE("room for " + std::to_string(room) + " bytes");
        Storage storage;
        SimulatedDisk& disk = storage.disk;
        Database database = std::move(storage.open().value());
        disk.set_capacity(disk.used() + room);
        std::uint64_t batch = 1;
        Result<void> put;
        while ((put = put_batch(database, batch))) ++batch;
        EXPECT_EQ(put.error().code, ErrorCode::no_space);
        EXPECT_EQ(put.error().sentence, "cannot write the database '/storage/jobs.sqlite': No space left on device");
        EXPECT_EQ(batches_in(database).size(), batch - 1);
        disk.set_capacity(disk.used() + 1'000'000);
        EXPECT_TRUE(put_batch(database, batch));
        EXPECT_EQ(batches_in(database).size(), batch);
    }
}

/// Not even after a power cut that leaves the refused transaction's pages on the disk.
TEST(DatabaseOnSimulatedDisk, WhatAFullDiskHasRefusedNeverAppears) {
    std::uint64_t refused = 0;
    for (std::uint64_t room = 0; room < 30'000; room += 512)
        for (std::uint64_t seed = 1; seed <= 5; ++seed) {
            Storage storage(seed);
            {
                Database database = std::move(storage.open().value());
                ASSERT_TRUE(put_batch(database, 1));
                storage.disk.set_capacity(storage.disk.used() + room);
                const auto put = put_batch(database, 2);
                storage.disk.power_off();
                if (put) continue;
                ASSERT_EQ(put.error().code, ErrorCode::no_space);
                ++refused;
            }
            std::mt19937_64 random(seed);
            storage.disk.crash(random);
            storage.disk.set_capacity(std::numeric_limits<std::uint64_t>::max());
            Database database = std::move(storage.open().value());
            EXPECT_FALSE(batches_in(database).contains(2)) << "room for " << room << " bytes, seed " << seed;
        }
    EXPECT_GT(refused, 0u);
}

TEST(DatabaseOnSimulatedDisk, AFailingSyncIsAFailure) {
    Storage storage;
    Database database = std::move(storage.open().value());
    storage.disk.fail_next_sync();
    const auto put = put_batch(database, 1);
    ASSERT_FALSE(put);
    EXPECT_EQ(put.error().code, ErrorCode::failed);
    EXPECT_EQ(put.error().sentence, "the database '/storage/jobs.sqlite' fails: disk I/O error");
    EXPECT_TRUE(batches_in(database).empty());
}

TEST(DatabaseOnSimulatedDisk, FailingReadsAndWritesAreFailures) {
    Storage storage;
    Database database = std::move(storage.open().value());
    storage.disk.fail_next_write();
    EXPECT_EQ(put_batch(database, 1).error().code, ErrorCode::failed);
    EXPECT_TRUE(put_batch(database, 1));
    storage.disk.fail_sometimes({.read = 1});
    EXPECT_EQ(Database::open("/storage/other.sqlite", schema, storage.vfs.name()).error().code, ErrorCode::failed);
}

TEST(DatabaseOnSimulatedDisk, ItsFilesLieThere) {
    Storage storage;
    {
        Database database = std::move(storage.open().value());
        ASSERT_TRUE(put_batch(database, 1));
        EXPECT_EQ(storage.disk.list("/storage").value(), (std::vector<std::string>{"jobs.sqlite", "jobs.sqlite-wal"}));
    }
    EXPECT_EQ(storage.disk.list("/storage").value(), std::vector<std::string>{"jobs.sqlite"});
    EXPECT_GT(storage.disk.used(), pages_per_batch * page_of(1, 0).size());
}

}  // namespace
}  // namespace lumenfarm::testing
