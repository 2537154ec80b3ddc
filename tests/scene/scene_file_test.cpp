#include "common/scene/scene_file.h"

#include "common/support/limits.h"
#include "tests/scene/sample_scene.h"

#include <gtest/gtest.h>

#include <random>

namespace lumenfarm {
namespace {

TEST(SceneFile, RoundTripKeepsEveryField) {
    const Scene scene = test::sample_scene();
    ASSERT_TRUE(validate(scene)) << validate(scene).error().sentence;
    const auto bytes = encode_scene(scene);
    const auto back = decode_scene(bytes);
    ASSERT_TRUE(back) << back.error().sentence;
    EXPECT_EQ(*back, scene);
    EXPECT_EQ(encode_scene(*back), bytes);
}

TEST(SceneFile, EveryTruncationIsRefused) {
    const auto bytes = encode_scene(test::sample_scene());
    for (std::size_t size = 0; size < bytes.size(); ++size)
        ASSERT_FALSE(decode_scene(std::span(bytes).first(size))) << size;
}

TEST(SceneFile, TrailingBytesAreRefused) {
    auto bytes = encode_scene(test::sample_scene());
    bytes.push_back(std::byte{0});
    EXPECT_FALSE(decode_scene(bytes));
}

TEST(SceneFile, AnotherVersionIsRefusedByNumber) {
    auto bytes = encode_scene(test::sample_scene());
    bytes[8] = std::byte{9};
    const auto result = decode_scene(bytes);
    ASSERT_FALSE(result);
    EXPECT_NE(result.error().sentence.find("version 9"), std::string::npos);
}

TEST(SceneFile, MutatedBytesAreDecodedToAValidSceneOrRefused) {
    const auto bytes = encode_scene(test::sample_scene());
    std::mt19937_64 random(7);
    std::size_t accepted = 0;
    for (int round = 0; round < 20'000; ++round) {
        auto mutated = bytes;
        for (std::uint64_t flips = 1 + random() % 4; flips > 0; --flips)
            mutated[random() % mutated.size()] = static_cast<std::byte>(random());
        if (const auto scene = decode_scene(mutated)) {
            ++accepted;
            ASSERT_TRUE(validate(*scene));
            ASSERT_EQ(encode_scene(*scene), mutated);
        }
    }
    EXPECT_GT(accepted, 0u);
}

TEST(SceneFile, AHugeCountIsRefusedWithoutTakingMemory) {
    auto bytes = encode_scene(test::sample_scene());
    for (std::size_t i = 12; i < 20; ++i) bytes[i] = std::byte{0xff};  // the count of positions
    EXPECT_FALSE(decode_scene(bytes));
    bytes[15] = bytes[16] = bytes[17] = bytes[18] = bytes[19] = std::byte{0};  // within the limit, beyond the bytes
    EXPECT_FALSE(decode_scene(bytes));
}

TEST(SceneFile, ChunksCoverTheBytesInOrder) {
    std::vector<std::byte> bytes(limits::chunk_bytes + 5, std::byte{3});
    const auto digests = chunk_digests(bytes);
    ASSERT_EQ(digests.size(), 2u);
    EXPECT_EQ(digests[0], sha256(std::span(bytes).first(limits::chunk_bytes)));
    EXPECT_EQ(digests[1], sha256(std::span(bytes).last(5)));
    EXPECT_EQ(chunk_digests(std::span(bytes).first(limits::chunk_bytes)).size(), 1u);
    EXPECT_EQ(chunk_digests({}).size(), 1u);
}

TEST(SceneFile, TheDigestNamesTheContent) {
    Scene scene = test::sample_scene();
    const Digest before = scene_digest(encode_scene(scene));
    scene.positions[0].x = 1e-6f;
    EXPECT_NE(scene_digest(encode_scene(scene)), before);
    EXPECT_EQ(scene_digest(encode_scene(test::sample_scene())), before);
}

}  // namespace
}  // namespace lumenfarm
