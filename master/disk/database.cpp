#include "master/disk/database.h"

#include <sqlite3.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdint>
#include <utility>

namespace lumenfarm {

namespace {

constexpr int log_pages = 1'000;
constexpr int rewrite_bytes = 64 << 10;   // SQLite takes less than 128 KiB in one call
constexpr int busy_milliseconds = 2'000;  // somebody may be looking into the file

/// SQLite says itself that a disk is full, but not that a quota is used up, or that there is no room for a new name.
bool is_full(sqlite3* connection) {
    const int code = sqlite3_extended_errcode(connection);
    if (code == SQLITE_FULL) return true;
    if (code != SQLITE_IOERR_WRITE && (code & 0xff) != SQLITE_CANTOPEN) return false;
    const int reason = sqlite3_system_errno(connection);
    return reason == ENOSPC || reason == EDQUOT;
}

/// Whether closing leaves the log as it is, instead of moving it into the database.
void close_quietly(sqlite3* connection, bool quietly) {
    sqlite3_db_config(connection, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, quietly ? 1 : 0, nullptr);
}

Error error_of(const std::string& file, sqlite3* connection) {
    if (is_full(connection)) return no_space("cannot write the database '" + file + "': No space left on device");
    Error error = failed("the database '" + file + "' fails: " + sqlite3_errmsg(connection));
    // after a failed sync the disk may lack the log, which could then not repair a database that is written in part
    if (connection) close_quietly(connection, true);
    return error;
}

/// Moves a log of many pages into the database, after a commit. SQLite's own way would not tell of a sync that failed.
int shorten_log(void* pages_max, sqlite3* connection, const char* database, int pages) {
    if (pages < static_cast<int>(reinterpret_cast<std::intptr_t>(pages_max))) return SQLITE_OK;
    const int code = sqlite3_wal_checkpoint_v2(connection, database, SQLITE_CHECKPOINT_PASSIVE, nullptr, nullptr);
    // the log keeps what a full disk has no second room for, or what somebody is reading; a later commit tries again
    const bool later = code == SQLITE_LOCKED || code == SQLITE_BUSY || (code != SQLITE_OK && is_full(connection));
    return later ? SQLITE_OK : code;
}

/// Writes the file over itself, and syncs it.
int rewrite(sqlite3_file& file) {
    const sqlite3_io_methods& call = *file.pMethods;
    sqlite3_int64 size = 0;
    int code = call.xFileSize(&file, &size);
    std::vector<std::byte> block(rewrite_bytes);
    for (sqlite3_int64 at = 0; code == SQLITE_OK && at < size; at += rewrite_bytes) {
        const int bytes = static_cast<int>(std::min<sqlite3_int64>(rewrite_bytes, size - at));
        code = call.xRead(&file, block.data(), bytes, at);
        if (code == SQLITE_OK) code = call.xWrite(&file, block.data(), bytes, at);
    }
    return code == SQLITE_OK && size > 0 ? call.xSync(&file, SQLITE_SYNC_NORMAL) : code;
}

}  // namespace

void Statement::Finalize::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

Statement& Statement::bind(std::uint64_t number) {
    const int code = sqlite3_bind_int64(statement_.get(), ++bound_, std::bit_cast<std::int64_t>(number));
    refused_ = refused_ || code != SQLITE_OK;
    return *this;
}

Statement& Statement::bind(std::span<const std::byte> bytes) {
    const int code =
        sqlite3_bind_blob64(statement_.get(), ++bound_, bytes.empty() ? "" : static_cast<const void*>(bytes.data()),
                            bytes.size(), SQLITE_STATIC);
    refused_ = refused_ || code != SQLITE_OK;
    return *this;
}

Result<bool> Statement::step() {
    const int code = refused_ ? SQLITE_ERROR : sqlite3_step(statement_.get());
    if (code == SQLITE_ROW) return true;
    Result<bool> end = false;
    if (code != SQLITE_DONE) end = error_of(file_, sqlite3_db_handle(statement_.get()));
    sqlite3_reset(statement_.get());
    sqlite3_clear_bindings(statement_.get());
    bound_ = 0;
    refused_ = false;
    return end;
}

Result<void> Statement::run() {
    const auto row = step();
    if (!row) return row.error();
    return {};
}

std::uint64_t Statement::number(int column) const {
    return std::bit_cast<std::uint64_t>(sqlite3_column_int64(statement_.get(), column));
}

std::vector<std::byte> Statement::bytes(int column) const {
    const auto* first = static_cast<const std::byte*>(sqlite3_column_blob(statement_.get(), column));
    return {first, first + sqlite3_column_bytes(statement_.get(), column)};
}

void Database::Shut::operator()(sqlite3* connection) const { sqlite3_close_v2(connection); }

Error Database::error() const { return error_of(file_, connection_.get()); }

Result<Database> Database::open(const std::filesystem::path& file, std::span<const char* const> schema,
                                const char* vfs) {
    Database database;
    database.file_ = file.string();
    sqlite3* connection = nullptr;
    const int code = sqlite3_open_v2(file.c_str(), &connection,
                                     SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX, vfs);
    database.connection_.reset(connection);
    if (code != SQLITE_OK) return database.error();
    if (const auto ready = database.prepare_file(); !ready) return ready.error();
    if (const auto sound = database.verify(); !sound) return sound.error();
    if (const auto migrated = database.migrate(schema); !migrated) return migrated.error();
    return database;
}

Result<void> Database::prepare_file() {
    sqlite3_busy_timeout(connection_.get(), busy_milliseconds);
    sqlite3_extended_result_codes(connection_.get(), 1);
    // exclusive: the log needs no shared memory, so the file may lie on any file system
    const auto set = execute(
        "PRAGMA locking_mode=EXCLUSIVE;"
        "PRAGMA journal_mode=WAL;"
        "PRAGMA synchronous=FULL;"
        "PRAGMA foreign_keys=ON;"
        "PRAGMA cell_size_check=ON;");
    if (!set) return set;
    limit_log(log_pages);
    return rewrite_log();
}

void Database::limit_log(int pages) {
    sqlite3_wal_hook(connection_.get(), shorten_log, reinterpret_cast<void*>(static_cast<std::intptr_t>(pages)));
}

Result<void> Database::rewrite_log() {
    close_quietly(connection_.get(), true);
    sqlite3_file* log = nullptr;
    sqlite3_file_control(connection_.get(), "main", SQLITE_FCNTL_JOURNAL_POINTER, &log);
    // a log that is padded behind the page that commits could be refused for want of room, and count nevertheless
    if (log && log->pMethods && !(log->pMethods->xDeviceCharacteristics(log) & SQLITE_IOCAP_POWERSAFE_OVERWRITE))
        return failed("the database '" + file_ + "' can't be kept: SQLite pads its log here");
    if (const int code = log && log->pMethods ? rewrite(*log) : SQLITE_OK; code != SQLITE_OK) {
        std::string sentence = "the database '" + file_ + "' fails: " + sqlite3_errstr(code);
        return code == SQLITE_FULL ? no_space(std::move(sentence)) : failed(std::move(sentence));
    }
    close_quietly(connection_.get(), false);
    return {};
}

Result<void> Database::verify() {
    auto check = prepare("PRAGMA integrity_check(1)");
    if (!check) return check.error();
    const auto row = check->step();
    if (!row) return row.error();
    const std::vector<std::byte> text = check->bytes(0);
    const std::string_view verdict(reinterpret_cast<const char*>(text.data()), text.size());
    if (verdict != "ok") return failed("the database '" + file_ + "' is damaged: " + std::string(verdict));
    return {};
}

Result<std::uint64_t> Database::ask_number(const char* sql) {
    auto asked = prepare(sql);
    if (!asked) return asked.error();
    const auto row = asked->step();
    if (!row) return row.error();
    return asked->number(0);
}

Result<void> Database::migrate(std::span<const char* const> schema) {
    const auto version = ask_number("PRAGMA user_version");
    if (!version) return version.error();
    if (*version > schema.size())
        return failed("the database '" + file_ + "' is of version " + std::to_string(*version) +
                      ", newer than this program knows (" + std::to_string(schema.size()) + ")");
    for (std::uint64_t at = *version; at < schema.size(); ++at) {
        auto step = begin();
        if (!step) return step.error();
        if (const auto made = execute(schema[at]); !made) return made.error();
        const std::string mark = "PRAGMA user_version=" + std::to_string(at + 1);
        if (const auto marked = execute(mark.c_str()); !marked) return marked.error();
        if (const auto done = step->commit(); !done) return done.error();
    }
    return {};
}

Result<Statement> Database::prepare(std::string_view sql) {
    sqlite3_stmt* made = nullptr;
    const int code = sqlite3_prepare_v3(connection_.get(), sql.data(), static_cast<int>(sql.size()), 0, &made, nullptr);
    Statement statement;
    statement.statement_.reset(made);
    statement.file_ = file_;
    if (code != SQLITE_OK) return error();
    return statement;
}

Result<void> Database::execute(const char* sql) {
    if (sqlite3_exec(connection_.get(), sql, nullptr, nullptr, nullptr) != SQLITE_OK) return error();
    return {};
}

Result<Database::Transaction> Database::begin() {
    if (const auto begun = execute("BEGIN IMMEDIATE"); !begun) return begun.error();
    return Transaction(*this);
}

Result<void> Database::Transaction::commit() {
    if (const auto done = database_->execute("COMMIT"); !done) return done.error();
    database_ = nullptr;
    return {};
}

Database::Transaction::~Transaction() {
    // SQLite may have rolled back already, after some errors
    if (database_ && sqlite3_get_autocommit(database_->connection_.get()) == 0) (void)database_->execute("ROLLBACK");
}

}  // namespace lumenfarm
