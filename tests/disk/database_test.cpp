#include "master/disk/database.h"

#include "tests/scratch/folder.h"

#include <gtest/gtest.h>

#include <array>

namespace lumenfarm {
namespace {

constexpr std::array first{"CREATE TABLE numbers (number INTEGER PRIMARY KEY) STRICT"};
constexpr std::array both{first[0], "ALTER TABLE numbers ADD COLUMN bytes BLOB"};

std::uint64_t count(Database& database) {
    Statement counted = std::move(database.prepare("SELECT count(*) FROM numbers").value());
    EXPECT_TRUE(counted.step().value());
    return counted.number(0);
}

TEST(Database, ATransactionThatIsNotCommittedNeverWas) {
    Database database = std::move(Database::open(":memory:", first).value());
    Statement insert = std::move(database.prepare("INSERT INTO numbers VALUES (?)").value());
    {
        auto all = database.begin();
        ASSERT_TRUE(all.has_value());
        ASSERT_TRUE(insert.bind(1).run().has_value());
        EXPECT_EQ(count(database), 1u);
    }
    EXPECT_EQ(count(database), 0u);
    {
        auto all = database.begin();
        ASSERT_TRUE(all.has_value());
        ASSERT_TRUE(insert.bind(2).run().has_value());
        ASSERT_TRUE(all->commit().has_value());
    }
    EXPECT_EQ(count(database), 1u);
}

TEST(Database, AStatementThatFailedCanBeUsedAgain) {
    Database database = std::move(Database::open(":memory:", first).value());
    Statement insert = std::move(database.prepare("INSERT INTO numbers VALUES (?)").value());
    ASSERT_TRUE(insert.bind(1).run().has_value());
    const auto again = insert.bind(1).run();
    ASSERT_FALSE(again.has_value());
    EXPECT_EQ(again.error().sentence, "the database ':memory:' fails: UNIQUE constraint failed: numbers.number");
    EXPECT_FALSE(insert.bind(2).bind(3).run().has_value()) << "there is no second parameter";
    EXPECT_TRUE(insert.bind(3).run().has_value());
    EXPECT_EQ(count(database), 2u);
}

TEST(Database, ACommitWhileAStatementReadsLeavesTheLogForLater) {
    const testing::Folder folder;
    Database database = std::move(Database::open(folder / "numbers.sqlite", first).value());
    database.limit_log(1);
    Statement insert = std::move(database.prepare("INSERT INTO numbers VALUES (?)").value());
    ASSERT_TRUE(insert.bind(1).run().has_value());
    Statement reader = std::move(database.prepare("SELECT number FROM numbers").value());
    ASSERT_TRUE(reader.step().value());
    const auto meanwhile = insert.bind(2).run();
    EXPECT_TRUE(meanwhile.has_value()) << meanwhile.error().sentence;
    while (reader.step().value()) {
    }
    EXPECT_TRUE(insert.bind(3).run().has_value());
    EXPECT_EQ(count(database), 3u);
}

TEST(Database, ALongLogOfALifeThatWasKilledIsTakenOver) {
    const testing::Folder folder;
    const auto file = folder / "numbers.sqlite", copy = folder / "copy.sqlite";
    Database database = std::move(Database::open(file, both).value());
    const std::vector<std::byte> bytes(1'000'000, std::byte{5});
    for (std::uint64_t i = 0; i < 3; ++i)
        ASSERT_TRUE(database.prepare("INSERT INTO numbers VALUES (?, ?)")->bind(i).bind(bytes).run().has_value());
    std::filesystem::copy_file(file, copy);
    std::filesystem::copy_file(file.string() + "-wal", copy.string() + "-wal");
    ASSERT_GT(std::filesystem::file_size(copy.string() + "-wal"), 2'000'000u);
    auto next = Database::open(copy, both);
    ASSERT_TRUE(next.has_value()) << next.error().sentence;
    EXPECT_EQ(count(*next), 3u);
}

TEST(Database, NumbersKeepAllBitsAndBytesAll) {
    Database database = std::move(Database::open(":memory:", both).value());
    constexpr std::uint64_t large = 0xffff'ffff'ffff'fff0;
    const std::array bytes{std::byte{0}, std::byte{7}, std::byte{0}};
    ASSERT_TRUE(database.prepare("INSERT INTO numbers VALUES (?, ?)")->bind(large).bind(bytes).run().has_value());
    ASSERT_TRUE(database.prepare("INSERT INTO numbers VALUES (?, ?)")
                    ->bind(5)
                    .bind(std::span<const std::byte>{})
                    .run()
                    .has_value());
    Statement rows = std::move(database.prepare("SELECT number, bytes FROM numbers ORDER BY number").value());
    ASSERT_TRUE(rows.step().value());
    EXPECT_EQ(rows.number(0), large);
    EXPECT_EQ(rows.bytes(1), std::vector<std::byte>(bytes.begin(), bytes.end()));
    ASSERT_TRUE(rows.step().value());
    EXPECT_TRUE(rows.bytes(1).empty());
    EXPECT_FALSE(rows.step().value());
}

TEST(Database, StatementsThatAreNotSqlAreRefused) {
    Database database = std::move(Database::open(":memory:", first).value());
    EXPECT_FALSE(database.prepare("SELECT nothing FROM nowhere").has_value());
}

}  // namespace
}  // namespace lumenfarm
