// The worst that a disk may do, and no worse: what was synced is there after any power cut.
#include "tests/simulation/simulated_disk.h"

#include "master/disk/disk_files.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <functional>
#include <set>

namespace lumenfarm::testing {
namespace {

using ::testing::AnyOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::uint64_t seeds = 200;

std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }

std::string text_of(Disk& disk, const std::string& path) {
    const auto bytes = read_whole(disk, path, 1'000'000).value();
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::unique_ptr<DiskFile> make(Disk& disk, const std::string& path) {
    return std::move(disk.open(path, DiskOpen::make).value());
}

/// A file that lasts.
void settle(Disk& disk, const std::string& path, std::string_view text) {
    const auto file = make(disk, path);
    ASSERT_TRUE(file->write(0, bytes_of(text)));
    ASSERT_TRUE(file->sync());
    ASSERT_TRUE(disk.sync_folder("/"));
}

/// What the file holds, or "missing", after a power cut, over many seeds.
std::set<std::string> outcomes(const std::string& path, const std::function<void(SimulatedDisk&)>& before) {
    std::set<std::string> seen;
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
        SimulatedDisk disk;
        before(disk);
        std::mt19937_64 random(seed);
        disk.crash(random);
        seen.insert(disk.exists(path) ? text_of(disk, path) : "missing");
    }
    return seen;
}

TEST(SimulatedDisk, WhatIsSyncedLasts) {
    const auto seen = outcomes("/a", [](SimulatedDisk& disk) {
        settle(disk, "/a", "first");
        const auto file = make(disk, "/a");
        ASSERT_TRUE(file->write(5, bytes_of(" second")));
        ASSERT_TRUE(file->truncate(8));
        ASSERT_TRUE(file->sync());
    });
    EXPECT_THAT(seen, ElementsAre("first se"));
}

TEST(SimulatedDisk, BytesThatAreNotSyncedMayLastOrNot) {
    const auto seen = outcomes("/a", [](SimulatedDisk& disk) {
        settle(disk, "/a", "old");
        ASSERT_TRUE(make(disk, "/a")->write(0, bytes_of("new")));
    });
    EXPECT_THAT(seen, ElementsAre("new", "old"));
}

TEST(SimulatedDisk, AWriteIsTornBetweenSectors) {
    const std::string old(1'500, 'a');
    const auto seen = outcomes("/a", [&](SimulatedDisk& disk) {
        settle(disk, "/a", old);
        ASSERT_TRUE(make(disk, "/a")->write(100, bytes_of(std::string(1'400, 'b'))));
    });
    std::set<std::string> possible{old};
    for (const std::size_t border : {512, 1'024, 1'500})
        possible.insert(std::string(100, 'a') + std::string(border - 100, 'b') + std::string(1'500 - border, 'a'));
    EXPECT_EQ(seen, possible);
}

TEST(SimulatedDisk, WritesReachTheDiskInAnyOrder) {
    const auto seen = outcomes("/a", [](SimulatedDisk& disk) {
        settle(disk, "/a", "..");
        const auto file = make(disk, "/a");
        ASSERT_TRUE(file->write(0, bytes_of("1")));
        ASSERT_TRUE(file->write(1, bytes_of("2")));
    });
    EXPECT_THAT(seen, ElementsAre("..", ".2", "1.", "12"));
}

TEST(SimulatedDisk, ALengthThatIsNotSyncedMayLastOrNot) {
    const auto seen = outcomes("/a", [](SimulatedDisk& disk) {
        settle(disk, "/a", "ab");
        ASSERT_TRUE(make(disk, "/a")->truncate(1));
    });
    EXPECT_THAT(seen, ElementsAre("a", "ab"));
    const auto longer = outcomes("/a", [](SimulatedDisk& disk) {
        settle(disk, "/a", "ab");
        ASSERT_TRUE(make(disk, "/a")->write(4, bytes_of("e")));
    });
    EXPECT_THAT(longer, ElementsAre("ab", std::string("ab\0\0e", 5)));
}

TEST(SimulatedDisk, ANameThatIsNotSyncedMayLastWithOrWithoutBytes) {
    const auto unsynced = [](SimulatedDisk& disk) { ASSERT_TRUE(make(disk, "/a")->write(0, bytes_of("a"))); };
    EXPECT_THAT(outcomes("/a", unsynced), ElementsAre("", "a", "missing"));
    const auto synced_bytes = [&](SimulatedDisk& disk) {
        unsynced(disk);
        ASSERT_TRUE(make(disk, "/a")->sync());
    };
    EXPECT_THAT(outcomes("/a", synced_bytes), ElementsAre("a", "missing"));
    const auto synced_name = [&](SimulatedDisk& disk) {
        unsynced(disk);
        ASSERT_TRUE(disk.sync_folder("/"));
    };
    EXPECT_THAT(outcomes("/a", synced_name), ElementsAre("", "a"));
}

TEST(SimulatedDisk, ARemovedFileMayComeBack) {
    const auto removed = [](SimulatedDisk& disk) {
        settle(disk, "/a", "a");
        ASSERT_TRUE(disk.remove("/a"));
        EXPECT_FALSE(disk.exists("/a"));
    };
    EXPECT_THAT(outcomes("/a", removed), ElementsAre("a", "missing"));
    const auto for_good = [&](SimulatedDisk& disk) {
        removed(disk);
        ASSERT_TRUE(disk.sync_folder("/"));
    };
    EXPECT_THAT(outcomes("/a", for_good), ElementsAre("missing"));
}

TEST(SimulatedDisk, NamesOfAFolderLastInTheirOrder) {
    std::set<std::vector<std::string>> seen;
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
        SimulatedDisk disk;
        settle(disk, "/a", "a");
        make(disk, "/b");
        ASSERT_TRUE(disk.rename("/a", "/b"));
        make(disk, "/c");
        std::mt19937_64 random(seed);
        disk.crash(random);
        seen.insert(disk.list("/").value());
    }
    using Names = std::vector<std::string>;
    EXPECT_EQ(seen, (std::set<Names>{{"a"}, {"a", "b"}, {"b"}, {"b", "c"}}));
}

TEST(SimulatedDisk, ARenamedFileThatWasNotSyncedMayBeEmpty) {
    const auto seen = outcomes("/a", [](SimulatedDisk& disk) {
        settle(disk, "/a", "old");
        ASSERT_TRUE(make(disk, "/a.part")->write(0, bytes_of("new")));
        ASSERT_TRUE(disk.rename("/a.part", "/a"));
    });
    EXPECT_THAT(seen, ElementsAre("", "new", "old"));
}

TEST(SimulatedDisk, OpenFilesEndWithThePower) {
    auto disk = std::make_unique<SimulatedDisk>();
    std::mt19937_64 random(1);
    const auto file = make(*disk, "/a");
    disk->power_off();
    EXPECT_EQ(file->write(0, bytes_of("a")).error().sentence, "cannot write '/a': the power is off");
    EXPECT_FALSE(disk->exists("/a"));
    EXPECT_THAT(disk->open("/b", DiskOpen::make).error().sentence, HasSubstr("the power is off"));
    EXPECT_FALSE(disk->list("/"));
    EXPECT_FALSE(disk->sync_folder("/"));
    disk->crash(random);
    EXPECT_TRUE(disk->open("/b", DiskOpen::make));
    const auto dead = file->sync();
    ASSERT_FALSE(dead);
    EXPECT_EQ(dead.error().code, ErrorCode::failed);
    EXPECT_FALSE(file->size());
    disk.reset();  // before the file
}

/// The power fails at each call in turn; gives the number of calls.
std::uint64_t at_every_call(const std::function<void(SimulatedDisk&)>& before,
                            const std::function<Result<void>(SimulatedDisk&)>& act,
                            const std::function<void(SimulatedDisk&, bool done)>& after) {
    for (std::uint64_t n = 1;; ++n) {
        for (std::uint64_t seed = 1; seed <= 20; ++seed) {
            SimulatedDisk disk;
            before(disk);
            disk.crash_at(n);
            const bool done = act(disk).has_value();
            const bool reached = !disk.has_power();
            EXPECT_EQ(done, !reached);
            std::mt19937_64 random(seed);
            disk.crash(random);
            after(disk, done);
            if (!reached && seed == 20) return n - 1;
        }
    }
}

TEST(SimulatedDisk, AWholeFileIsOldOrNewWhereverThePowerFails) {
    std::set<std::string> undone;
    const std::uint64_t calls =
        at_every_call([](SimulatedDisk& disk) { settle(disk, "/a", "old"); },
                      [](SimulatedDisk& disk) { return write_whole(disk, "/a", bytes_of("new")); },
                      [&](SimulatedDisk& disk, bool done) {
                          const std::string text = text_of(disk, "/a");
                          EXPECT_THAT(text, AnyOf("old", "new"));
                          EXPECT_TRUE(!done || text == "new");
                          if (!done) undone.insert(text);
                      });
    EXPECT_EQ(calls, 6u) << "open, truncate, write, sync, rename, sync of the folder";
    EXPECT_THAT(undone, ElementsAre("new", "old"));
}

TEST(SimulatedDisk, CallsThatChangeAreCounted) {
    SimulatedDisk disk;
    ASSERT_TRUE(disk.make_folder("/a/b"));
    EXPECT_EQ(disk.calls(), 2u);
    const auto file = make(disk, "/a/b/c");
    (void)make(disk, "/a/b/c");
    EXPECT_EQ(disk.calls(), 3u) << "only the first makes the file";
    ASSERT_TRUE(file->write(0, bytes_of("a")));
    ASSERT_TRUE(file->truncate(0));
    ASSERT_TRUE(file->sync());
    ASSERT_TRUE(disk.rename("/a/b/c", "/a/b/d"));
    ASSERT_TRUE(disk.sync_folder("/a/b"));
    ASSERT_TRUE(disk.remove("/a/b/d"));
    EXPECT_EQ(disk.calls(), 9u);
    ASSERT_TRUE(file->size());
    ASSERT_TRUE(disk.list("/a/b"));
    EXPECT_EQ(disk.calls(), 9u);
}

TEST(SimulatedDisk, FoldersLastAndFilesNeedThem) {
    SimulatedDisk disk;
    EXPECT_FALSE(disk.open("/a/b/c", DiskOpen::make));
    ASSERT_TRUE(disk.make_folder("/a/b/"));
    std::mt19937_64 random(1);
    disk.crash(random);
    EXPECT_TRUE(disk.exists("/a/b"));
    EXPECT_TRUE(disk.open("/a/./b/c", DiskOpen::make));
    EXPECT_THAT(disk.list("/a/b").value(), ElementsAre("c"));
    EXPECT_THAT(disk.list("/a").value(), IsEmpty());
    EXPECT_FALSE(disk.list("/b"));
    EXPECT_EQ(disk.open("/a/b/d", DiskOpen::existing).error().code, ErrorCode::bad_input);
}

TEST(SimulatedDisk, AFullDiskTakesWhatFits) {
    SimulatedDisk disk;
    settle(disk, "/a", "1234");
    disk.set_capacity(7);
    const auto file = make(disk, "/b");
    const auto written = file->write(0, bytes_of("56789"));
    ASSERT_FALSE(written);
    EXPECT_EQ(written.error().code, ErrorCode::no_space);
    EXPECT_EQ(written.error().sentence, "cannot write '/b': No space left on device");
    EXPECT_EQ(text_of(disk, "/b"), "567");
    EXPECT_TRUE(file->write(0, bytes_of("765"))) << "what is there can be changed";
    EXPECT_EQ(file->truncate(4).error().code, ErrorCode::no_space);
    ASSERT_TRUE(disk.remove("/a"));
    EXPECT_TRUE(file->write(0, bytes_of("56789")));
    EXPECT_EQ(disk.used(), 5u);
    disk.set_capacity(4);
    EXPECT_EQ(write_whole(disk, "/c", bytes_of("c")).error().code, ErrorCode::no_space);
    EXPECT_THAT(disk.list("/").value(), ElementsAre("b")) << "nothing is left of it";
}

TEST(SimulatedDisk, BytesOfAFailedSyncMayNeverLast) {
    std::set<std::string> seen;
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
        SimulatedDisk disk(seed);
        settle(disk, "/a", "old");
        const auto file = make(disk, "/a");
        ASSERT_TRUE(file->write(0, bytes_of("new")));
        disk.fail_next_sync();
        EXPECT_EQ(file->sync().error().sentence, "cannot sync '/a': Input/output error");
        EXPECT_TRUE(file->sync()) << "as if nothing had been";
        EXPECT_EQ(text_of(disk, "/a"), "new") << "as long as there is power";
        std::mt19937_64 random(seed);
        disk.crash(random);
        seen.insert(text_of(disk, "/a"));
    }
    EXPECT_THAT(seen, ElementsAre("new", "old"));
}

TEST(SimulatedDisk, CallsFailAsTheyAreTold) {
    SimulatedDisk disk;
    settle(disk, "/a", "abc");
    const auto file = make(disk, "/a");
    std::array<std::byte, 3> some{};
    disk.fail_next_read();
    EXPECT_EQ(file->read(0, some).error().sentence, "cannot read '/a': Input/output error");
    EXPECT_TRUE(file->read(0, some));
    disk.fail_next_write();
    EXPECT_EQ(file->write(0, bytes_of("x")).error().code, ErrorCode::failed);
    EXPECT_EQ(text_of(disk, "/a"), "abc");
    disk.fail_next_sync();
    EXPECT_EQ(disk.sync_folder("/").error().code, ErrorCode::failed);

    disk.fail_sometimes({.sync = 0.5});
    int failed_syncs = 0;
    for (int i = 0; i < 100; ++i) failed_syncs += file->sync() ? 0 : 1;
    EXPECT_GT(failed_syncs, 20);
    EXPECT_LT(failed_syncs, 80);
    disk.fail_sometimes({});
    EXPECT_TRUE(file->sync());
}

}  // namespace
}  // namespace lumenfarm::testing
