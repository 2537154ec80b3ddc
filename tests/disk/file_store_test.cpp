#include "master/disk/file_store.h"

#include "common/scene/scene_file.h"
#include "common/support/limits.h"
#include "master/disk/disk_files.h"
#include "master/disk/posix_disk.h"
#include "tests/scratch/folder.h"

#include <gmock/gmock.h>

#include <algorithm>

namespace lumenfarm {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::UnorderedElementsAre;

using Bytes = std::vector<std::byte>;

Bytes bytes_of(std::size_t count, int start) {
    Bytes bytes(count);
    for (std::size_t i = 0; i < count; ++i) bytes[i] = static_cast<std::byte>(start + i % 251);
    return bytes;
}

wire::FileManifest manifest_of(const Bytes& bytes) { return {sha256(bytes), bytes.size(), chunk_digests(bytes)}; }

wire::Chunk chunk_of(const Bytes& bytes, std::uint32_t index) {
    const std::size_t first = index * limits::chunk_bytes;
    const std::size_t end = std::min(bytes.size(), first + limits::chunk_bytes);
    return {sha256(bytes), index, Bytes(bytes.begin() + first, bytes.begin() + end)};
}

class FileStoreFolder : public ::testing::Test {
protected:
    void SetUp() override { ASSERT_TRUE(store_.open()); }

    std::vector<std::string> names() const { return disk_.list(folder_ / "files").value(); }
    /// Changes a stored byte as nobody should.
    void damage(const Digest& file) {
        const auto opened = disk_.open(store_.path(file), DiskOpen::existing);
        std::array<std::byte, 1> byte{};
        ASSERT_EQ((*opened)->read(1, byte).value(), 1u);
        byte[0] ^= std::byte{0x40};
        ASSERT_TRUE((*opened)->write(1, byte));
    }

    testing::Folder folder_;
    PosixDisk disk_;
    FileStore store_{disk_, folder_ / "files"};
    const Bytes large_ = bytes_of(2 * limits::chunk_bytes + 5, 1);  ///< three chunks
};

TEST_F(FileStoreFolder, AFileIsReadUnderItsDigest) {
    for (const std::size_t size : {std::size_t{0}, std::size_t{10}, limits::chunk_bytes + 1}) {
        const Bytes bytes = bytes_of(size, 3);
        const auto file = store_.put(bytes);
        ASSERT_TRUE(file);
        EXPECT_EQ(*file, sha256(bytes));
        EXPECT_EQ(store_.read(*file).value(), bytes);
        EXPECT_EQ(store_.manifest(*file).value(), manifest_of(bytes));
    }
}

TEST_F(FileStoreFolder, AFileThatIsNotHereIsBadInput) {
    const Digest file = sha256(large_);
    EXPECT_EQ(store_.read(file).error().code, ErrorCode::bad_input);
    EXPECT_EQ(store_.manifest(file).error().code, ErrorCode::bad_input);
    EXPECT_EQ(store_.chunk(file, 0).error().sentence, "there is no file " + file.hex());
}

TEST_F(FileStoreFolder, ChunksOfAFileAreItsBytes) {
    const Digest file = store_.put(large_).value();
    for (const std::uint32_t index : {0u, 1u, 2u})
        EXPECT_EQ(store_.chunk(file, index).value(), chunk_of(large_, index).bytes);
    EXPECT_EQ(store_.chunk(file, 3).error().code, ErrorCode::bad_input);
    const Digest empty = store_.put({}).value();
    EXPECT_THAT(store_.chunk(empty, 0).value(), IsEmpty());
}

TEST_F(FileStoreFolder, ADamagedFileIsNotRead) {
    const Digest file = store_.put(large_).value();
    damage(file);
    const auto read = store_.read(file);
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().code, ErrorCode::bad_input);
    EXPECT_EQ(read.error().sentence, "'" + store_.path(file).string() + "' is damaged: its digest differs");
    EXPECT_EQ(store_.manifest(file).error().code, ErrorCode::bad_input);
    ASSERT_TRUE(store_.put(large_));
    EXPECT_EQ(store_.read(file).value(), large_);
}

TEST_F(FileStoreFolder, AnUploadAppearsWithItsLastChunk) {
    const wire::FileManifest manifest = manifest_of(large_);
    EXPECT_THAT(store_.missing(manifest).value(), ElementsAre(0, 1, 2));
    ASSERT_TRUE(store_.put_chunk(chunk_of(large_, 2)));
    ASSERT_TRUE(store_.put_chunk(chunk_of(large_, 2))) << "twice is fine";
    ASSERT_TRUE(store_.put_chunk(chunk_of(large_, 0)));
    EXPECT_THAT(store_.missing(manifest).value(), ElementsAre(1));
    EXPECT_EQ(store_.read(manifest.file).error().code, ErrorCode::bad_input);
    ASSERT_TRUE(store_.put_chunk(chunk_of(large_, 1)));
    EXPECT_THAT(store_.missing(manifest).value(), IsEmpty());
    EXPECT_EQ(store_.read(manifest.file).value(), large_);
    EXPECT_THAT(names(), ElementsAre(manifest.file.hex()));
}

TEST_F(FileStoreFolder, ADamagedChunkStaysMissing) {
    const wire::FileManifest manifest = manifest_of(large_);
    ASSERT_TRUE(store_.missing(manifest));
    wire::Chunk other = chunk_of(large_, 1);
    other.bytes[7] ^= std::byte{1};
    EXPECT_EQ(store_.put_chunk(other).error().sentence, "chunk 1 of " + manifest.file.hex() + " is damaged");
    wire::Chunk shorter = chunk_of(large_, 1);
    shorter.bytes.pop_back();
    EXPECT_EQ(store_.put_chunk(shorter).error().code, ErrorCode::bad_input);
    EXPECT_THAT(store_.missing(manifest).value(), ElementsAre(0, 1, 2));
}

TEST_F(FileStoreFolder, AChunkThatNobodyAskedForIsRefused) {
    EXPECT_EQ(store_.put_chunk(chunk_of(large_, 0)).error().code, ErrorCode::bad_input);
    ASSERT_TRUE(store_.missing(manifest_of(large_)));
    wire::Chunk beyond = chunk_of(large_, 0);
    beyond.index = 3;
    EXPECT_EQ(store_.put_chunk(beyond).error().code, ErrorCode::bad_input);
}

TEST_F(FileStoreFolder, ChunksThatMakeAnotherFileNeverAppear) {
    wire::FileManifest lie = manifest_of(large_);
    lie.file = sha256(bytes_of(10, 1));
    ASSERT_TRUE(store_.missing(lie));
    Result<void> last;
    for (const std::uint32_t index : {0u, 1u, 2u}) {
        wire::Chunk chunk = chunk_of(large_, index);
        chunk.file = lie.file;
        last = store_.put_chunk(chunk);
    }
    ASSERT_FALSE(last);
    EXPECT_EQ(last.error().code, ErrorCode::bad_input);
    EXPECT_THAT(names(), IsEmpty());
    EXPECT_THAT(store_.missing(lie).value(), ElementsAre(0, 1, 2));
}

TEST_F(FileStoreFolder, AFileThatIsPutWhileItIsUploadedStays) {
    const wire::FileManifest manifest = manifest_of(large_);
    ASSERT_TRUE(store_.missing(manifest));
    ASSERT_TRUE(store_.put_chunk(chunk_of(large_, 0)));
    ASSERT_TRUE(store_.put(large_));
    EXPECT_THAT(store_.missing(manifest).value(), IsEmpty());
    for (const std::uint32_t index : {1u, 2u}) ASSERT_TRUE(store_.put_chunk(chunk_of(large_, index)));
    EXPECT_EQ(store_.read(manifest.file).value(), large_);
    EXPECT_THAT(names(), ElementsAre(manifest.file.hex()));
}

TEST_F(FileStoreFolder, AnotherManifestOfTheSameFileBeginsItsUploadAnew) {
    wire::FileManifest lie = manifest_of(large_);
    std::swap(lie.chunks[0], lie.chunks[1]);
    ASSERT_TRUE(store_.missing(lie));
    ASSERT_TRUE(store_.put_chunk(chunk_of(large_, 2)));
    EXPECT_THAT(store_.missing(manifest_of(large_)).value(), ElementsAre(0, 1, 2));
    EXPECT_THAT(store_.take_displaced(), ElementsAre(sha256(large_)));
    for (const std::uint32_t index : {0u, 1u, 2u}) ASSERT_TRUE(store_.put_chunk(chunk_of(large_, index)));
    EXPECT_EQ(store_.read(sha256(large_)).value(), large_);
}

TEST_F(FileStoreFolder, TheOldestUploadMakesRoom) {
    std::vector<Bytes> files;
    for (std::size_t i = 0; i <= limits::uploads_max; ++i) {
        files.push_back(bytes_of(10 + i, 0));
        EXPECT_THAT(store_.missing(manifest_of(files.back())).value(), ElementsAre(0));
    }
    EXPECT_THAT(names(), SizeIs(limits::uploads_max));
    EXPECT_EQ(store_.put_chunk(chunk_of(files.front(), 0)).error().code, ErrorCode::bad_input);
    EXPECT_TRUE(store_.put_chunk(chunk_of(files[1], 0)));
    EXPECT_THAT(store_.take_displaced(), ElementsAre(sha256(files.front())));
    EXPECT_THAT(store_.take_displaced(), IsEmpty());
}

TEST_F(FileStoreFolder, OnlyWholeFilesOutliveTheMaster) {
    const Digest kept = store_.put(bytes_of(10, 1)).value();
    ASSERT_TRUE(store_.missing(manifest_of(large_)));
    ASSERT_TRUE(disk_.open(folder_ / "files" / (kept.hex() + ".part"), DiskOpen::make));
    ASSERT_THAT(names(), SizeIs(3));
    FileStore next(disk_, folder_ / "files");
    ASSERT_TRUE(next.open());
    EXPECT_THAT(names(), ElementsAre(kept.hex()));
    EXPECT_EQ(next.put_chunk(chunk_of(large_, 0)).error().code, ErrorCode::bad_input);
}

TEST_F(FileStoreFolder, ARemovedFileIsGoneWithItsManifest) {
    const Digest file = store_.put(large_).value();
    ASSERT_TRUE(store_.manifest(file));
    EXPECT_TRUE(store_.remove(file));
    EXPECT_TRUE(store_.remove(file)) << "gone already";
    EXPECT_EQ(store_.manifest(file).error().code, ErrorCode::bad_input);
    EXPECT_THAT(store_.missing(manifest_of(large_)).value(), ElementsAre(0, 1, 2));
}

TEST_F(FileStoreFolder, AllOtherFilesAreRemovedAndUploadsStay) {
    std::vector<Digest> files;
    for (const int start : {1, 2, 3, 4}) files.push_back(store_.put(bytes_of(100, start)).value());
    const wire::FileManifest manifest = manifest_of(large_);
    ASSERT_TRUE(store_.missing(manifest));
    const Digest never_here = sha256(bytes_of(1, 9));
    EXPECT_EQ(store_.remove_others({files[1], files[3], never_here}).value(), 2u);
    EXPECT_THAT(names(), UnorderedElementsAre(files[1].hex(), files[3].hex(), manifest.file.hex() + ".upload"));
    EXPECT_EQ(store_.remove_others({files[1], files[3]}).value(), 0u);
    for (const std::uint32_t index : {0u, 1u, 2u}) ASSERT_TRUE(store_.put_chunk(chunk_of(large_, index)));
    EXPECT_EQ(store_.read(manifest.file).value(), large_);
}

}  // namespace
}  // namespace lumenfarm
