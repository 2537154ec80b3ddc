#include "master/disk/posix_disk.h"

#include "common/support/file.h"
#include "master/disk/disk_files.h"
#include "tests/scratch/folder.h"

#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <cerrno>
#include <csignal>

namespace lumenfarm {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }

class PosixDiskFolder : public ::testing::Test {
protected:
    std::unique_ptr<DiskFile> make(const std::string& name) {
        return std::move(disk_.open(folder_ / name, DiskOpen::make).value());
    }
    std::string text(const std::string& name) {
        const auto bytes = read_whole(disk_, folder_ / name, 1'000'000).value();
        return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    }
    std::vector<std::string> names() const { return disk_.list(folder_.path()).value(); }

    testing::Folder folder_;
    PosixDisk disk_;
};

TEST_F(PosixDiskFolder, BytesAreReadWhereTheyWereWritten) {
    const auto file = make("a");
    ASSERT_TRUE(file->write(2, bytes_of("cdef")));
    ASSERT_TRUE(file->write(3, bytes_of("D")));
    EXPECT_EQ(file->size().value(), 6u);
    EXPECT_EQ(text("a"), std::string("\0\0cDef", 6));
    ASSERT_TRUE(file->truncate(3));
    ASSERT_TRUE(file->sync());
    EXPECT_EQ(text("a"), std::string("\0\0c", 3));
}

TEST_F(PosixDiskFolder, FreeBytesAreThoseOfTheDiskOfTheFolder) {
    const auto free = disk_.free_bytes(folder_.path());
    ASSERT_TRUE(free.has_value());
    EXPECT_GT(*free, 0u);
    EXPECT_LE(*free, fs::space(folder_.path()).capacity);
    EXPECT_EQ(disk_.free_bytes("/dev/shm/none/at/all").error().code, ErrorCode::failed);
}

TEST_F(PosixDiskFolder, AReadEndsWithTheFile) {
    const auto file = make("a");
    ASSERT_TRUE(file->write(0, bytes_of("abcdef")));
    std::array<std::byte, 4> some{};
    EXPECT_EQ(file->read(0, some).value(), 4u);
    EXPECT_EQ(file->read(4, some).value(), 2u);
    EXPECT_EQ(file->read(6, some).value(), 0u);
}

TEST_F(PosixDiskFolder, OnlyAFileThatIsToBeMadeMayBeMissing) {
    const auto missing = disk_.open(folder_ / "a", DiskOpen::existing);
    ASSERT_FALSE(missing);
    EXPECT_EQ(missing.error().code, ErrorCode::bad_input);
    EXPECT_EQ(missing.error().sentence, "cannot open '" + (folder_ / "a").string() + "': No such file or directory");
    EXPECT_FALSE(disk_.exists(folder_ / "a"));
    make("a");
    EXPECT_TRUE(disk_.exists(folder_ / "a"));
    EXPECT_TRUE(disk_.open(folder_ / "a", DiskOpen::existing));

    const auto nowhere = disk_.open(folder_ / "no" / "a", DiskOpen::make);
    ASSERT_FALSE(nowhere);
    EXPECT_EQ(nowhere.error().code, ErrorCode::failed);
}

TEST_F(PosixDiskFolder, ANewFileIsForItsOwnerToWriteAndForAllToRead) {
    const mode_t before = ::umask(0);
    make("a");
    ::umask(before);
    const auto all = fs::status(folder_ / "a").permissions();
    EXPECT_EQ(static_cast<unsigned>(all), 0644u);
}

TEST_F(PosixDiskFolder, ARenamedFileTakesTheOthersPlace) {
    ASSERT_TRUE(make("a")->write(0, bytes_of("new")));
    ASSERT_TRUE(make("b")->write(0, bytes_of("old")));
    ASSERT_TRUE(disk_.rename(folder_ / "a", folder_ / "b"));
    EXPECT_THAT(names(), ElementsAre("b"));
    EXPECT_EQ(text("b"), "new");
    EXPECT_EQ(disk_.rename(folder_ / "a", folder_ / "b").error().code, ErrorCode::failed);
}

TEST_F(PosixDiskFolder, AMissingFileIsRemovedAlready) {
    make("a");
    EXPECT_TRUE(disk_.remove(folder_ / "a"));
    EXPECT_TRUE(disk_.remove(folder_ / "a"));
    EXPECT_THAT(names(), IsEmpty());
}

TEST_F(PosixDiskFolder, AListNamesFilesInOrderAndNoFolders) {
    for (const char* name : {"c", "a", "b"}) make(name);
    ASSERT_TRUE(disk_.make_folder(folder_ / "aa"));
    EXPECT_THAT(names(), ElementsAre("a", "b", "c"));
    EXPECT_THAT(disk_.list(folder_ / "no").error().sentence, HasSubstr("No such file or directory"));
}

TEST_F(PosixDiskFolder, FoldersAreMadeWithTheirParents) {
    ASSERT_TRUE(disk_.make_folder(folder_ / "a" / "b" / "c"));
    ASSERT_TRUE(disk_.make_folder(folder_ / "a" / "b" / "c"));
    ASSERT_TRUE(disk_.make_folder(folder_ / "d" / "e" / ""));
    EXPECT_TRUE(fs::is_directory(folder_ / "a" / "b" / "c"));
    EXPECT_TRUE(fs::is_directory(folder_ / "d" / "e"));
    EXPECT_TRUE(disk_.sync_folder(folder_ / "a"));
    EXPECT_EQ(disk_.sync_folder(folder_ / "no").error().code, ErrorCode::failed);
    make("file");
    EXPECT_EQ(disk_.make_folder(folder_ / "file").error().code, ErrorCode::failed);
}

TEST_F(PosixDiskFolder, AFullDiskIsNoFailure) {
    if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
    const auto file = disk_.open("/dev/full", DiskOpen::existing);
    ASSERT_TRUE(file);
    const auto written = (*file)->write(0, bytes_of("a"));
    ASSERT_FALSE(written);
    EXPECT_EQ(written.error().code, ErrorCode::no_space);
    EXPECT_EQ(written.error().sentence, "cannot write '/dev/full': No space left on device");
}

TEST(DiskError, AQuotaIsAFullDiskAndAllElseAFailure) {
    EXPECT_EQ(disk_error("cannot write 'a'", ENOSPC).code, ErrorCode::no_space);
    EXPECT_EQ(disk_error("cannot write 'a'", EDQUOT).code, ErrorCode::no_space);
    EXPECT_EQ(disk_error("cannot write 'a'", EIO).code, ErrorCode::failed);
    EXPECT_EQ(disk_error("cannot write 'a'", EIO).sentence, "cannot write 'a': Input/output error");
}

/// Files can't grow beyond so many bytes while this lives.
class FileSizeLimit {
public:
    explicit FileSizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
        ::getrlimit(RLIMIT_FSIZE, &before_);
        const rlimit limit{bytes, before_.rlim_max};
        ::setrlimit(RLIMIT_FSIZE, &limit);
    }
    ~FileSizeLimit() {
        ::setrlimit(RLIMIT_FSIZE, &before_);
        std::signal(SIGXFSZ, handler_);
    }
    FileSizeLimit(const FileSizeLimit&) = delete;
    FileSizeLimit& operator=(const FileSizeLimit&) = delete;

private:
    void (*handler_)(int);
    rlimit before_{};
};

TEST_F(PosixDiskFolder, AWholeFileIsWrittenOrTheOldOneStays) {
    ASSERT_TRUE(write_whole(disk_, folder_ / "a", bytes_of("old")));
    make("a.part")->write(0, bytes_of("longer than what comes, of an earlier life"));
    ASSERT_TRUE(write_whole(disk_, folder_ / "a", bytes_of("newer")));
    EXPECT_EQ(text("a"), "newer");
    const std::string large(100'000, 'x');
    {
        const FileSizeLimit limit(50'000);
        EXPECT_EQ(write_whole(disk_, folder_ / "a", bytes_of(large)).error().code, ErrorCode::failed);
    }
    EXPECT_EQ(text("a"), "newer");
    EXPECT_THAT(names(), ElementsAre("a"));
}

TEST_F(PosixDiskFolder, AWholeFileIsReadUpToALimit) {
    ASSERT_TRUE(write_whole(disk_, folder_ / "a", bytes_of("four")));
    EXPECT_EQ(read_whole(disk_, folder_ / "a", 4).value().size(), 4u);
    const auto larger = read_whole(disk_, folder_ / "a", 3);
    ASSERT_FALSE(larger);
    EXPECT_EQ(larger.error().code, ErrorCode::bad_input);
    EXPECT_THAT(larger.error().sentence, HasSubstr("has 4 bytes; the limit is 3"));
    EXPECT_EQ(read_whole(disk_, folder_ / "b", 4).error().code, ErrorCode::bad_input);
}

}  // namespace
}  // namespace lumenfarm
