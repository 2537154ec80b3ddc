#include "cli/output_folder.h"
#include "cli/temporary_folder.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace lumenfarm {
namespace {

namespace fs = std::filesystem;

class OutputFolderTest : public ::testing::Test {
protected:
    OutputFolderTest() : home_(TemporaryFolder::make().value()) {}
    fs::path home(const std::string& name) const { return home_.path() / name; }

private:
    TemporaryFolder home_;
};

TEST_F(OutputFolderTest, GoesAgainWhenNothingWasWritten) {
    {
        const auto folder = OutputFolder::open(home("out"));
        ASSERT_TRUE(folder);
        EXPECT_TRUE(fs::is_directory(home("out")));
    }
    EXPECT_FALSE(fs::exists(home("out")));
}

TEST_F(OutputFolderTest, StaysWithWhatWasWritten) {
    {
        const auto folder = OutputFolder::open(home("out"));
        ASSERT_TRUE(folder);
        std::ofstream(home("out") / "solution.lfs") << "x";
    }
    EXPECT_TRUE(fs::exists(home("out") / "solution.lfs"));
}

TEST_F(OutputFolderTest, FolderOfTheUsersStaysEvenEmpty) {
    fs::create_directory(home("out"));
    ASSERT_TRUE(OutputFolder::open(home("out")));
    EXPECT_TRUE(fs::is_directory(home("out")));
    EXPECT_TRUE(fs::is_empty(home("out")));
}

TEST_F(OutputFolderTest, SweepTakesOnlyHalfWrittenFilesOfThisProcess) {
    const auto folder = OutputFolder::open(home("out"));
    ASSERT_TRUE(folder);
    const fs::path mine = home("out") / ("a.exr.part-" + std::to_string(::getpid()));
    const fs::path other = home("out") / "a.exr.part-1";
    const fs::path whole = home("out") / "solution.lfs";
    for (const auto& path : {mine, other, whole}) std::ofstream(path) << "x";
    folder->sweep();
    EXPECT_FALSE(fs::exists(mine));
    EXPECT_TRUE(fs::exists(other));
    EXPECT_TRUE(fs::exists(whole));
}

TEST_F(OutputFolderTest, FileInTheWayIsTold) {
    std::ofstream(home("out")) << "x";
    const auto folder = OutputFolder::open(home("out"));
    ASSERT_FALSE(folder);
    EXPECT_NE(folder.error().sentence.find(home("out").string()), std::string::npos);
}

TEST_F(OutputFolderTest, FilesAreProbedWithoutATrace) {
    EXPECT_TRUE(check_file_writable(home("lux.csv")));
    EXPECT_FALSE(fs::exists(home("lux.csv")));
    EXPECT_FALSE(check_file_writable(home("missing") / "lux.csv"));
    EXPECT_FALSE(check_file_writable(home("")));
}

TEST_F(OutputFolderTest, TemporaryFolderGoesWithItsContents) {
    fs::path path;
    {
        const auto folder = TemporaryFolder::make();
        ASSERT_TRUE(folder);
        path = folder->path();
        std::ofstream(path / "x") << "x";
    }
    EXPECT_FALSE(fs::exists(path));
}

}  // namespace
}  // namespace lumenfarm
