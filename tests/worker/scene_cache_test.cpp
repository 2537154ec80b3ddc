#include "worker/scene_cache.h"

#include "common/scene/scene_file.h"
#include "common/support/file.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>

namespace lumenfarm::worker {
namespace {

namespace fs = std::filesystem;

class SceneCacheTest : public ::testing::Test {
protected:
    SceneCacheTest() {
        folder_ = fs::path(::testing::TempDir()) /
                  (std::string("cache_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
        fs::remove_all(folder_);
    }
    ~SceneCacheTest() override { fs::remove_all(folder_); }

    static std::vector<std::byte> scene(int value, std::size_t bytes = 1'000) {
        return std::vector<std::byte>(bytes, static_cast<std::byte>(value));
    }
    fs::path folder_;
};

TEST_F(SceneCacheTest, KeepsAndLoads) {
    const SceneCache cache(folder_, 1'000'000);
    EXPECT_EQ(cache.load(scene_digest(scene(1))).value(), nullptr);
    ASSERT_TRUE(cache.keep(scene_digest(scene(1)), scene(1)));
    ASSERT_NE(cache.load(scene_digest(scene(1))).value(), nullptr);
    EXPECT_EQ(*cache.load(scene_digest(scene(1))).value(), scene(1));
}

TEST_F(SceneCacheTest, DamagedFileIsNamedAndRemoved) {
    const SceneCache cache(folder_, 1'000'000);
    const Digest name = scene_digest(scene(1));
    ASSERT_TRUE(cache.keep(name, scene(1)));
    ASSERT_TRUE(write_file(folder_ / name.hex(), scene(2)));
    const auto loaded = cache.load(name);
    ASSERT_FALSE(loaded);
    EXPECT_NE(loaded.error().sentence.find(name.hex()), std::string::npos);
    EXPECT_FALSE(fs::exists(folder_ / name.hex()));
}

TEST_F(SceneCacheTest, StaysWithinItsSize) {
    const SceneCache cache(folder_, 2'500);
    std::size_t displaced = 0;
    for (int i = 0; i < 5; ++i) displaced += cache.keep(scene_digest(scene(i)), scene(i)).value().size();
    EXPECT_EQ(displaced, 3u);
    int kept = 0;
    for (int i = 0; i < 5; ++i) kept += cache.load(scene_digest(scene(i))).value() != nullptr;
    EXPECT_EQ(kept, 2);
    EXPECT_NE(cache.load(scene_digest(scene(4))).value(), nullptr) << "the newest stays";
    EXPECT_FALSE(cache.keep(scene_digest(scene(9, 9'000)), scene(9, 9'000))) << "too large to be kept";
    EXPECT_EQ(cache.load(scene_digest(scene(9, 9'000))).value(), nullptr);
}

TEST_F(SceneCacheTest, WhatAKilledWorkerWasWritingGoesAndWhatALiveOneWritesStays) {
    const std::string name = scene_digest(scene(1)).hex() + ".part-";
    fs::create_directories(folder_);
    const fs::path dead = folder_ / (name + "4194305"), live = folder_ / (name + std::to_string(getppid()));
    for (const fs::path& part : {dead, live}) ASSERT_TRUE(write_file(part, scene(1)));
    ASSERT_TRUE(SceneCache(folder_, 1'000'000).keep(scene_digest(scene(2)), scene(2)));
    EXPECT_FALSE(fs::exists(dead)) << "no process has a number above 2^22";
    EXPECT_TRUE(fs::exists(live));
}

TEST_F(SceneCacheTest, UnwritableFolderIsASentence) {
    ASSERT_TRUE(write_file(folder_, std::string("a file")));
    const auto kept = SceneCache(folder_, 1'000'000).keep(scene_digest(scene(1)), scene(1));
    ASSERT_FALSE(kept);
    EXPECT_NE(kept.error().sentence.find(folder_.string()), std::string::npos);
}

}  // namespace
}  // namespace lumenfarm::worker
