#include "common/solution/solution_file.h"

#include "common/solution/block_codec.h"
#include "common/support/file.h"
#include "tests/solution/synthetic.h"

#include <gtest/gtest.h>
#include <xxhash.h>

#include <cstring>
#include <filesystem>
#include <random>

namespace lumenfarm {
namespace {

LoadedRun sample_run() {
    JobSpec spec;
    spec.particles = 640;
    spec.texel_m = 2;
    spec.keep_hits = 5;
    spec.name = "sample";
    LoadedRun run = test::empty_run(test::sheet_scene(), spec);
    test::fill(run, test::uniform_records(5, run.scene, 40));
    run.solution.time = {1.5, 2.5, 3};
    return run;
}

void seal(std::vector<std::byte>& bytes) {
    const std::uint64_t sum = XXH3_64bits(bytes.data(), bytes.size() - 8);
    std::memcpy(bytes.data() + bytes.size() - 8, &sum, 8);
}

TEST(SolutionFile, ReadsBackWhatWasWritten) {
    const LoadedRun run = sample_run();
    const EncodedSolution encoded = encode_solution(run.solution);
    EXPECT_EQ(encoded.digest, solution_digest(run.solution));
    const auto read = decode_solution(encoded.bytes, run.scene, run.scene_name);
    ASSERT_TRUE(read) << read.error().sentence;
    EXPECT_EQ(read->spec, run.solution.spec);
    EXPECT_EQ(read->committed, run.solution.committed);
    EXPECT_EQ(read->balance, run.solution.balance);
    EXPECT_EQ(read->texels, run.solution.texels);
    EXPECT_EQ(read->surfaces, run.solution.surfaces);
    EXPECT_EQ(read->kept, run.solution.kept);
    EXPECT_EQ(read->time.trace_s, 2.5);
    EXPECT_EQ(solution_digest(*read), solution_digest(run.solution));
}

TEST(SolutionFile, ReadsBackMoreTexelsThanAreWrittenAtOnce) {
    JobSpec spec;
    spec.particles = 100'000;
    spec.texel_m = 0.03;
    LoadedRun run = test::empty_run(test::sheet_scene(), spec);
    test::fill(run, test::uniform_records(7, run.scene, 50'000));
    ASSERT_GT(run.solution.texels.size(), 30'000u);
    const auto read = decode_solution(encode_solution(run.solution).bytes, run.scene, run.scene_name);
    ASSERT_TRUE(read) << read.error().sentence;
    EXPECT_EQ(read->texels, run.solution.texels);
}

TEST(SolutionFile, CutShortAnywhereItIsRefusedWithASentence) {
    const LoadedRun run = sample_run();
    const auto bytes = encode_solution(run.solution).bytes;
    for (std::size_t size = 0; size < bytes.size(); ++size) {
        const auto read = decode_solution(std::span(bytes).first(size), run.scene, run.scene_name);
        ASSERT_FALSE(read) << size;
        EXPECT_EQ(read.error().code, ErrorCode::bad_input);
        EXPECT_FALSE(read.error().sentence.empty());
    }
}

TEST(SolutionFile, AFlippedBitAnywhereIsNoticed) {
    const LoadedRun run = sample_run();
    const auto bytes = encode_solution(run.solution).bytes;
    for (std::size_t at = 0; at < bytes.size(); ++at) {
        auto damaged = bytes;
        damaged[at] ^= std::byte{1} << (at % 8);
        EXPECT_FALSE(decode_solution(damaged, run.scene, run.scene_name)) << at;
    }
}

TEST(SolutionFile, ForgedFilesWithGoodChecksumsAreRefusedOrTheSame) {
    // whoever forges a file can seal it: the digest and the checks of every field must hold then
    const LoadedRun run = sample_run();
    const auto bytes = encode_solution(run.solution).bytes;
    std::mt19937_64 random(11);
    int refused = 0;
    for (int i = 0; i < 3'000; ++i) {
        auto forged = bytes;
        for (auto changes = 1 + random() % 4; changes > 0; --changes)
            forged[random() % (forged.size() - 8)] = static_cast<std::byte>(random());
        if (random() % 8 == 0) forged.resize(52 + random() % forged.size());
        seal(forged);
        const auto read = decode_solution(forged, run.scene, run.scene_name);
        if (read)
            EXPECT_EQ(solution_digest(*read), solution_digest(run.solution));
        else
            ++refused;
    }
    EXPECT_GT(refused, 2'500);
}

TEST(SolutionFile, SumsThatDoNotAgreeAreRefused) {
    const LoadedRun run = sample_run();
    const auto refused = [&](auto change) {
        Solution forged = run.solution;
        change(forged);
        return !decode_solution(encode_solution(forged).bytes, run.scene, run.scene_name);
    };
    EXPECT_TRUE(refused([](Solution& s) { s.balance.absorbed += 1; }));
    EXPECT_TRUE(refused([](Solution& s) { s.balance.emitted_by_batch[0] += 1; }));
    EXPECT_TRUE(refused([](Solution& s) { s.balance.hits += 1; }));
    EXPECT_TRUE(refused([](Solution& s) { s.balance.particles -= 1; }));
    EXPECT_TRUE(refused([](Solution& s) { s.texels.pop_back(); }));
    EXPECT_TRUE(refused([](Solution& s) { s.texels[0].y += 1; }));
    EXPECT_TRUE(refused([](Solution& s) { s.surfaces.emplace_back(); }));
    EXPECT_TRUE(refused([](Solution& s) { s.kept.pop_back(); }));
    EXPECT_TRUE(refused([](Solution& s) { std::swap(s.kept[0], s.kept[1]); }));
    EXPECT_TRUE(refused([](Solution& s) { s.kept[0].record.triangle = 77; }));
    EXPECT_TRUE(refused([](Solution& s) { s.committed.emplace_back(); }));
    EXPECT_TRUE(refused([](Solution& s) {
        s.committed[0] = {};
        s.committed[0].insert(1'000, 1'640);
    }));
    EXPECT_TRUE(refused([](Solution& s) { s.spec.particles = 0; }));
    EXPECT_TRUE(refused([](Solution& s) { s.time.total_s = std::nan(""); }));
}

TEST(SolutionFile, OfAnotherSceneItSaysSo) {
    const LoadedRun run = sample_run();
    Digest other = run.scene_name;
    other.bytes[0] ^= 1;
    const auto read = decode_solution(encode_solution(run.solution).bytes, run.scene, other);
    ASSERT_FALSE(read);
    EXPECT_NE(read.error().sentence.find(other.hex()), std::string::npos);
}

TEST(BlockCodec, RefusesSizesThatTheBlockCannotUnfoldTo) {
    ByteWriter out;
    write_block(out, std::vector<std::byte>(100'000));
    auto bytes = out.take();
    ByteReader whole(bytes);
    EXPECT_TRUE(read_block(whole, 100'000));
    ByteReader tight(bytes);
    EXPECT_FALSE(read_block(tight, 99'999));
    const std::uint64_t absurd = std::uint64_t{1} << 60;
    std::memcpy(bytes.data(), &absurd, 8);
    ByteReader bomb(bytes);
    EXPECT_FALSE(read_block(bomb, absurd));
}

TEST(BlockCodec, ReadsBackWhatCameInPieces) {
    std::vector<std::byte> raw(300'000);
    for (std::size_t i = 0; i < raw.size(); ++i) raw[i] = static_cast<std::byte>(i * i >> 5);
    ByteWriter out;
    out.text("before");
    write_block(out, raw.size(), [&](const TakePiece& take) {
        for (std::size_t begin = 0; begin < raw.size(); begin += 7'001)
            take(std::span(raw).subspan(begin, std::min<std::size_t>(7'001, raw.size() - begin)));
    });
    out.text("behind");
    ByteReader in(out.bytes());
    EXPECT_EQ(in.text(100), "before");
    const auto read = read_block(in, raw.size());
    ASSERT_TRUE(read) << read.error().sentence;
    EXPECT_EQ(*read, raw);
    EXPECT_EQ(in.text(100), "behind");
    EXPECT_EQ(in.remaining(), 0u);
}

class RunFolder : public testing::Test {
protected:
    RunFolder() : folder_(std::filesystem::path(testing::TempDir()) / ("lumenfarm_" + name())) {
        std::filesystem::remove_all(folder_);
    }
    ~RunFolder() override { std::filesystem::remove_all(folder_); }
    static std::string name() { return testing::UnitTest::GetInstance()->current_test_info()->name(); }
    std::filesystem::path folder_;
};

TEST_F(RunFolder, LoadsByFolderAndByFile) {
    const LoadedRun run = sample_run();
    ASSERT_TRUE(save_run(folder_, encode_scene(run.scene), run.solution));
    for (const auto& path : {folder_, folder_ / solution_file_name}) {
        const auto loaded = load_run(path);
        ASSERT_TRUE(loaded) << loaded.error().sentence;
        EXPECT_EQ(solution_digest(loaded->solution), solution_digest(run.solution));
        EXPECT_EQ(loaded->scene, run.scene);
        EXPECT_EQ(loaded->scene_name, run.scene_name);
    }
}

TEST_F(RunFolder, AMissingOrForeignFileIsNamed) {
    const auto nothing = load_run(folder_);
    ASSERT_FALSE(nothing);
    EXPECT_NE(nothing.error().sentence.find("solution.lfs"), std::string::npos);
    const LoadedRun run = sample_run();
    ASSERT_TRUE(save_run(folder_, encode_scene(run.scene), run.solution));
    Scene other = run.scene;
    other.positions[0].x += 0.5f;
    ASSERT_TRUE(write_file(folder_ / scene_file_name, encode_scene(other)));
    const auto foreign = load_run(folder_);
    ASSERT_FALSE(foreign);
    EXPECT_EQ(foreign.error().code, ErrorCode::bad_input);
    EXPECT_NE(foreign.error().sentence.find("solution.lfs"), std::string::npos);
}

}  // namespace
}  // namespace lumenfarm
