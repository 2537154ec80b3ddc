// A file that the store has taken outlives the power, wherever it fails; one that it has not is not there in part.
#include "common/scene/scene_file.h"
#include "common/support/limits.h"
#include "master/disk/file_store.h"
#include "tests/simulation/simulated_disk.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <functional>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace lumenfarm::testing {
namespace {

using ::testing::SizeIs;

using Bytes = std::vector<std::byte>;
constexpr std::uint64_t seeds = 12;

Bytes bytes_of(std::size_t count) {
    Bytes bytes(count);
    for (std::size_t i = 0; i < count; ++i) bytes[i] = static_cast<std::byte>(i * 31 % 251);
    return bytes;
}

const Bytes& two_chunks() {
    static const Bytes bytes = bytes_of(limits::chunk_bytes + 700);
    return bytes;
}

Result<void> put(FileStore& store) {
    if (const auto file = store.put(bytes_of(3'000)); !file) return file.error();
    return {};
}

Result<void> upload(FileStore& store) {
    const Bytes& bytes = two_chunks();
    const auto missing = store.missing({sha256(bytes), bytes.size(), chunk_digests(bytes)});
    if (!missing) return missing.error();
    for (const std::uint32_t index : *missing) {
        const std::size_t first = index * limits::chunk_bytes;
        const std::size_t end = std::min(bytes.size(), first + limits::chunk_bytes);
        const Bytes chunk(bytes.begin() + first, bytes.begin() + end);
        if (const auto taken = store.put_chunk({sha256(bytes), index, chunk}); !taken) return taken;
    }
    return {};
}

/// `act` gives the store a file of these bytes. The power fails at each of its calls in turn.
void take_at_every_call(const Bytes& bytes, const std::function<Result<void>(FileStore&)>& act) {
    const Digest file = sha256(bytes);
    std::uint64_t lasting_early = 0;
    bool reached = true;
    for (std::uint64_t n = 1; reached; ++n) {
        for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
            SCOPED_TRACE("the power fails at call " + std::to_string(n) + ", seed " + std::to_string(seed));
            SimulatedDisk disk(seed);
            disk.crash_at(n);
            bool taken = false;
            {
                FileStore store(disk, "/storage/files");
                taken = store.open() && act(store);
            }
            reached = !disk.has_power();
            std::mt19937_64 random(seed);
            disk.crash(random);
            FileStore store(disk, "/storage/files");
            ASSERT_TRUE(store.open());
            const auto read = store.read(file);
            EXPECT_TRUE(!read || *read == bytes);
            ASSERT_TRUE(read || (!taken && read.error().code == ErrorCode::bad_input)) << read.error().sentence;
            EXPECT_THAT(disk.list("/storage/files").value(), SizeIs(read ? 1 : 0));
            lasting_early += read && !taken ? 1 : 0;
            ASSERT_TRUE(act(store));
            EXPECT_TRUE(store.read(file).value() == bytes);
        }
    }
    EXPECT_GT(lasting_early, 0u);
}

TEST(FileStoreOnSimulatedDisk, AFilePutIsWholeOrNotThere) { take_at_every_call(bytes_of(3'000), put); }

TEST(FileStoreOnSimulatedDisk, AnUploadIsWholeOrNotThere) { take_at_every_call(two_chunks(), upload); }

TEST(FileStoreOnSimulatedDisk, AFullDiskTakesNothingAndLaterTheSame) {
    for (const auto& act : {put, upload}) {
        SimulatedDisk disk;
        FileStore store(disk, "/storage/files");
        ASSERT_TRUE(store.open());
        disk.set_capacity(2'000);
        const auto taken = act(store);
        ASSERT_FALSE(taken);
        EXPECT_EQ(taken.error().code, ErrorCode::no_space);
        disk.set_capacity(10 * limits::chunk_bytes);
        EXPECT_TRUE(act(store));
        EXPECT_THAT(disk.list("/storage/files").value(), SizeIs(1));
    }
}

TEST(FileStoreOnSimulatedDisk, AFileWhoseSyncFailedIsNotHere) {
    for (const auto& act : {put, upload}) {
        std::set<std::string> ends;
        for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
            SimulatedDisk disk(seed);
            FileStore store(disk, "/storage/files");
            ASSERT_TRUE(store.open());
            disk.fail_sometimes({.sync = 0.5});
            const auto taken = act(store);
            EXPECT_TRUE(taken || taken.error().code == ErrorCode::failed);
            EXPECT_THAT(disk.list("/storage/files").value(), SizeIs(taken ? 1 : 0)) << "nobody may rely on it";
            ends.insert(taken ? "taken" : taken.error().sentence);
        }
        EXPECT_THAT(ends, SizeIs(3)) << "the sync of the file fails, that of the folder, or none";
    }
}

}  // namespace
}  // namespace lumenfarm::testing
