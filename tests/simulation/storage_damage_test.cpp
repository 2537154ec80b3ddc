#include "tests/simulation/simulated_disk.h"
#include "tests/simulation/simulated_vfs.h"
#include "tests/simulation/small_job.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>
#include <set>

/// A master's storage of which bytes are flipped, or cut off. LUMENFARM_TEST_EVERY_BYTE: not only some of them.
namespace lumenfarm::testing {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t results = 4;

/// The files of a disk, and a disk again.
using Image = std::map<fs::path, std::vector<std::byte>>;

Image image_of(SimulatedDisk& disk) {
    Image image;
    for (const char* folder : {"/storage", "/storage/files", "/storage/segments"})
        for (const std::string& name : disk.list(folder).value()) {
            const auto file = std::move(disk.open(fs::path(folder) / name, DiskOpen::existing).value());
            std::vector<std::byte> bytes(file->size().value());
            EXPECT_EQ(file->read(0, bytes).value(), bytes.size());
            image.emplace(fs::path(folder) / name, std::move(bytes));
        }
    return image;
}

void restore(SimulatedDisk& disk, const Image& image) {
    for (const char* folder : {"/storage/files", "/storage/segments"})
        ASSERT_TRUE(disk.make_folder(folder).has_value());
    for (const auto& [path, bytes] : image) {
        const auto file = std::move(disk.open(path, DiskOpen::make).value());
        ASSERT_TRUE(file->write(0, bytes).has_value());
    }
}

class DamagedStorage : public ::testing::Test {
protected:
    /// A master that took four results, and was killed after the last.
    DamagedStorage() {
        SimulatedDisk disk;
        const SimulatedVfs vfs(disk);
        auto storage = std::move(Storage::open(disk, "/storage", vfs.name()).value());
        job_.begin(*storage);
        for (std::uint64_t number = 0; number < results; ++number) {
            if (number + 2 == results) before_last_two_ = image_of(disk);
            const StoredLease lease{1, {100 + number, 7, {0, 1'000 + 10 * number, 10}}};
            EXPECT_TRUE(storage->commit({{job_.stored(number)}, {{lease}, {}}}).has_value());
        }
        disk.power_off();
        storage.reset();
        disk.kill();
        image_ = image_of(disk);
        for (std::uint64_t subset = 0; subset < 1u << results; ++subset) digests_[sums_of(subset)] = subset;
    }

    Digest sums_of(std::uint64_t subset) const {
        std::vector<std::uint64_t> those;
        for (std::uint64_t number = 0; number < results; ++number)
            if (subset >> number & 1) those.push_back(number);
        return job_.sums_of(those);
    }

    /// What a master finds on this disk.
    struct Found {
        std::optional<Error> refused;  ///< it does not start, or not this job
        bool warned = false;
        std::uint64_t subset = 0;  ///< of the results
        std::vector<std::string> damages;
    };
    Found start_on(const Image& image) const {
        SimulatedDisk disk;
        restore(disk, image);
        const SimulatedVfs vfs(disk);
        const auto storage = Storage::open(disk, "/storage", vfs.name());
        if (!storage) return {storage.error(), false, 0, {}};
        const auto start = (*storage)->start();
        if (!start) return {start.error(), false, 0, {}};
        if (start->records.empty()) return {std::nullopt, !start->warnings.empty(), 0, {}};
        const auto recovered = (*storage)->prepare({start->records.front()});
        if (!recovered) return {recovered.error(), false, 0, {}};
        const auto solution = (*storage)->store(StoreSolution{start->records.front(), {}});
        EXPECT_TRUE(solution.has_value());
        const auto subset = digests_.find(solution->status.digest.value());
        EXPECT_NE(subset, digests_.end()) << "sums of no results that there were";
        return {std::nullopt, false, subset == digests_.end() ? 0 : subset->second, recovered->damages};
    }

    static std::size_t step(std::size_t some) { return std::getenv("LUMENFARM_TEST_EVERY_BYTE") ? 1 : some; }

    const SmallJob job_;
    const std::vector<std::byte>& scene_ = job_.scene;
    const JobRecord& record_ = job_.record;
    Image before_last_two_, image_;
    std::map<Digest, std::uint64_t> digests_;  ///< of the sums of each subset of the results
    const fs::path segment_ = "/storage/segments/1-0", log_ = "/storage/jobs.sqlite-wal";
};

TEST_F(DamagedStorage, WithoutDamageEverythingIsThere) {
    const Found found = start_on(image_);
    EXPECT_FALSE(found.refused);
    EXPECT_TRUE(found.damages.empty());
    EXPECT_EQ(found.subset, (1u << results) - 1);
}

TEST_F(DamagedStorage, AFlippedByteOfAResultCostsThatResultAndIsNamed) {
    const std::size_t begin = before_last_two_.at(segment_).size(), end = image_.at(segment_).size();
    ASSERT_GT(end - begin, 1'000u);
    std::set<std::uint64_t> subsets;
    for (std::size_t at = begin; at < end; at += step(7)) {
        Image damaged = image_;
        damaged.at(segment_)[at] ^= std::byte{0x20};
        const Found found = start_on(damaged);
        ASSERT_FALSE(found.refused) << "byte " << at;
        ASSERT_EQ(found.damages.size(), 1u) << "byte " << at;
        EXPECT_NE(found.damages[0].find("/storage/segments/1-0' is damaged at byte"), std::string::npos);
        subsets.insert(found.subset);
    }
    EXPECT_EQ(subsets, (std::set<std::uint64_t>{0b0111, 0b1011}));
}

TEST_F(DamagedStorage, ASegmentThatWasCutCostsWhatIsGone) {
    const std::size_t begin = before_last_two_.at(segment_).size(), end = image_.at(segment_).size();
    for (std::size_t size = begin; size < end; size += step(13)) {
        Image damaged = image_;
        damaged.at(segment_).resize(size);
        const Found found = start_on(damaged);
        ASSERT_FALSE(found.refused) << "size " << size;
        EXPECT_EQ(found.damages.size(), found.subset == 0b0011 ? 2u : 1u) << "size " << size;
        EXPECT_TRUE(found.subset == 0b0011 || found.subset == 0b0111) << "size " << size;
    }
    Image damaged = image_;
    damaged.erase(segment_);
    EXPECT_EQ(start_on(damaged).subset, 0u);
    EXPECT_EQ(start_on(damaged).damages.size(), results);
}

TEST_F(DamagedStorage, ALogThatIsDamagedOrCutGivesAnEarlierCommitOrASentence) {
    const std::size_t begin = before_last_two_.at(log_).size(), end = image_.at(log_).size();
    ASSERT_GT(end, begin);
    std::set<std::uint64_t> subsets;
    const auto check = [&](const Image& damaged, std::size_t at) {
        const Found found = start_on(damaged);
        if (found.refused) {
            EXPECT_FALSE(found.refused->sentence.empty());
            return;
        }
        EXPECT_FALSE(found.warned) << "byte " << at;
        EXPECT_TRUE(found.damages.empty()) << "byte " << at;
        subsets.insert(found.subset);
    };
    for (std::size_t at = begin; at < end; at += step(211)) {
        Image damaged = image_;
        damaged.at(log_)[at] ^= std::byte{0x04};
        check(damaged, at);
        damaged = image_;
        damaged.at(log_).resize(at);
        check(damaged, at);
    }
    // SQLite fills its log up behind the last commit, where damage does no harm
    EXPECT_THAT(subsets, ::testing::IsSupersetOf({0b0011u, 0b0111u}));
    EXPECT_THAT(subsets, ::testing::Each(::testing::AnyOf(0b0011u, 0b0111u, 0b1111u)));
}

TEST_F(DamagedStorage, ARowThatWasChangedIsLeftOut) {
    const auto tampered = [&](const char* sql) {
        SimulatedDisk disk;
        restore(disk, image_);
        const SimulatedVfs vfs(disk);
        const std::array versions{"-- 1", "-- 2"};
        EXPECT_TRUE(Database::open("/storage/jobs.sqlite", versions, vfs.name())->execute(sql).has_value());
        return start_on(image_of(disk));
    };
    const char* changes[] = {"UPDATE results SET first_byte = first_byte + 1 WHERE number = 1",
                             "UPDATE results SET bytes = bytes + 1 WHERE number = 1",
                             "UPDATE results SET bytes = -1 WHERE number = 1",
                             "UPDATE results SET segment = 7 WHERE number = 1",
                             "UPDATE results SET number = 9 WHERE number = 1",
                             "UPDATE results SET bytes_checksum = 1 WHERE number = 1",
                             "UPDATE results SET checksum = 1 WHERE number = 1"};
    for (const char* change : changes) {
        const Found found = tampered(change);
        EXPECT_EQ(found.subset, 0b1101u) << change;
        ASSERT_EQ(found.damages.size(), 1u) << change;
        EXPECT_EQ(found.damages[0], "1 rows of job 1 are damaged in the database");
    }
}

TEST_F(DamagedStorage, ASnapshotThatIsDamagedIsLostAndWhatCameAfterItIsNot) {
    SimulatedDisk disk;
    restore(disk, image_);
    const SimulatedVfs vfs(disk);
    auto storage = std::move(Storage::open(disk, "/storage", vfs.name()).value());
    ASSERT_TRUE(storage->start().has_value());
    ASSERT_TRUE(storage->prepare({record_}).has_value());
    const std::size_t files = disk.list("/storage/files").value().size();
    const auto all = (1u << results) - 1;
    ASSERT_TRUE(storage->store(StoreSnapshot{1, {}}).has_value());
    EXPECT_EQ(disk.list("/storage/files").value().size(), files) << "so few results are not worth a snapshot";
    ASSERT_TRUE(storage->store(StoreSnapshot{1, {}, true}).has_value());
    ASSERT_EQ(disk.list("/storage/files").value().size(), files + 1);
    EXPECT_TRUE(disk.list("/storage/segments").value().empty());
    storage.reset();
    Image image = image_of(disk);
    EXPECT_EQ(start_on(image).subset, all);
    for (auto& [path, bytes] : image)
        if (path.parent_path() == "/storage/files" && path.filename() != record_.status.scene.hex())
            bytes[bytes.size() / 2] ^= std::byte{1};
    const Found found = start_on(image);
    EXPECT_EQ(found.subset, 0u);
    ASSERT_EQ(found.damages.size(), 1u);
    EXPECT_NE(found.damages[0].find("the snapshot of job 1 is lost"), std::string::npos);
}

TEST_F(DamagedStorage, ASceneThatIsDamagedCostsNothingAndIsMendedByAnotherJobOfIt) {
    SimulatedDisk disk;
    Image image = image_;
    image.at("/storage/files" / fs::path(record_.status.scene.hex()))[99] ^= std::byte{1};
    restore(disk, image);
    const SimulatedVfs vfs(disk);
    auto storage = std::move(Storage::open(disk, "/storage", vfs.name()).value());
    const auto start = storage->start();
    ASSERT_TRUE(start.has_value());
    const auto refused = storage->prepare({start->records.front()});
    ASSERT_FALSE(refused.has_value());
    EXPECT_NE(refused.error().sentence.find("is damaged: its digest differs"), std::string::npos);

    Admit admit;
    admit.record = record_;
    admit.record.key = 4;
    admit.record.status.job = 2;
    admit.submit = wire::Submit(4, record_.spec, {record_.status.scene, scene_.size(), chunk_digests(scene_)});
    const auto missing = storage->admit(admit);
    ASSERT_TRUE(missing.has_value());
    EXPECT_EQ(*missing, std::vector<std::uint32_t>{0});
    ASSERT_TRUE(storage->put_chunk({record_.status.scene, 0, scene_}).has_value());
    EXPECT_TRUE(storage->admit(admit).value().empty());

    const auto recovered = storage->prepare({start->records.front()});
    ASSERT_TRUE(recovered.has_value());
    EXPECT_TRUE(recovered->damages.empty());
    const auto solution = storage->store(StoreSolution{start->records.front(), {}});
    EXPECT_EQ(digests_.at(solution->status.digest.value()), (1u << results) - 1);
}

}  // namespace
}  // namespace lumenfarm::testing
