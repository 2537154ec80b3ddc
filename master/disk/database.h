#pragma once

#include "common/support/result.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

struct sqlite3;
struct sqlite3_stmt;

/// An SQLite file. What a transaction has committed is on the disk when commit() returns (WAL, synchronous=FULL);
/// what it has not, never was. Errors of this page are no_space (the disk is full; roll back, and the file can be used
/// as before) and failed (close it: what a failed sync has left on the disk, open() finds out): the sentence names the
/// file and SQLite's reason.
namespace lumenfarm {

/// A prepared statement. Numbers keep all 64 bits, signed or not.
class Statement {
public:
    /// Sets the next parameter, from the first one on.
    Statement& bind(std::uint64_t number);
    /// The bytes must stay until step() has returned.
    Statement& bind(std::span<const std::byte> bytes);

    /// True: a row is here. False: there are no more, and the statement may be bound anew.
    Result<bool> step();
    /// For statements that give no rows.
    Result<void> run();

    // of the row, by column from 0 on
    std::uint64_t number(int column) const;
    std::vector<std::byte> bytes(int column) const;

private:
    friend class Database;
    struct Finalize {
        void operator()(sqlite3_stmt* statement) const;
    };
    std::unique_ptr<sqlite3_stmt, Finalize> statement_;
    std::string file_;
    int bound_ = 0;
    bool refused_ = false;  ///< a parameter could not be set
};

/// Not thread-safe: one thread at a time.
class Database {
public:
    /// Opens the file or makes it, and verifies its structure. `schema[v]` takes a file of version v to v + 1.
    /// `vfs` is SQLite's name for what lies between it and the disk; null: the system's. Errors also: failed (damaged,
    /// or of a newer version than these).
    static Result<Database> open(const std::filesystem::path& file, std::span<const char* const> schema,
                                 const char* vfs = nullptr);

    Result<Statement> prepare(std::string_view sql);
    /// One or several statements without rows.
    Result<void> execute(const char* sql);

    /// Several changes at once, or none of them: what is not committed is rolled back. After a commit that failed
    /// nobody knows: the next to open the file may find them.
    class Transaction {
    public:
        Transaction(Transaction&& other) noexcept : database_(std::exchange(other.database_, nullptr)) {}
        Transaction& operator=(Transaction&&) = delete;
        ~Transaction();
        Result<void> commit();

    private:
        friend class Database;
        explicit Transaction(Database& database) : database_(&database) {}
        Database* database_;
    };
    Result<Transaction> begin();

    /// A commit that leaves a log of so many pages moves it into the file.
    void limit_log(int pages);

private:
    struct Shut {
        void operator()(sqlite3* connection) const;
    };
    Result<void> prepare_file();
    /// Where a sync failed in an earlier life, the system's memory may hold a log that the disk does not: a power cut
    /// would end it in its midst, whatever was committed behind. So it is written again before it is relied on.
    Result<void> rewrite_log();
    Result<void> verify();
    Result<void> migrate(std::span<const char* const> schema);
    Result<std::uint64_t> ask_number(const char* sql);
    Error error() const;

    std::unique_ptr<sqlite3, Shut> connection_;
    std::string file_;
};

}  // namespace lumenfarm
