#include "master/job_store.h"

#include <xxhash.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

namespace lumenfarm {

namespace {

// docs/operations.md, "The storage folder". Record: checksum seeded with the job. Other tables: over the numbers of the
// row, in the order of its columns.
constexpr std::array schema{
    "CREATE TABLE jobs (job INTEGER PRIMARY KEY, record BLOB NOT NULL, checksum INTEGER NOT NULL) STRICT;"
    "CREATE TABLE lives (one INTEGER PRIMARY KEY CHECK (one = 1), begun INTEGER NOT NULL,"
    " checksum INTEGER NOT NULL) STRICT;",

    "CREATE TABLE results (job INTEGER NOT NULL, number INTEGER NOT NULL, segment INTEGER NOT NULL,"
    " first_byte INTEGER NOT NULL, bytes INTEGER NOT NULL, bytes_checksum INTEGER NOT NULL,"
    " machine INTEGER NOT NULL, checksum INTEGER NOT NULL, PRIMARY KEY (job, number)) STRICT, WITHOUT ROWID;"
    "CREATE TABLE leases (lease INTEGER PRIMARY KEY, job INTEGER NOT NULL, worker INTEGER NOT NULL,"
    " light INTEGER NOT NULL, first INTEGER NOT NULL, count INTEGER NOT NULL, checksum INTEGER NOT NULL) STRICT;"
    "CREATE INDEX leases_of_job ON leases (job);"
    "CREATE TABLE snapshots (job INTEGER PRIMARY KEY, next_result INTEGER NOT NULL, file BLOB NOT NULL,"
    " checksum INTEGER NOT NULL) STRICT;"
    // the highest number of a removed job: damage to it may at worst cost a number
    "CREATE TABLE removed (one INTEGER PRIMARY KEY CHECK (one = 1), last INTEGER NOT NULL) STRICT;"};

std::uint64_t checksum(JobId job, std::span<const std::byte> record) {
    return XXH3_64bits_withSeed(record.data(), record.size(), job);
}

std::uint64_t checksum_of_lives(std::uint32_t begun) { return XXH3_64bits(&begun, sizeof begun); }

std::uint64_t checksum(std::span<const std::uint64_t> numbers) {
    return XXH3_64bits(numbers.data(), numbers.size_bytes());
}

std::array<std::uint64_t, 7> numbers_of(const StoredResult& result) {
    return {result.job, result.number, result.segment, result.offset, result.bytes, result.checksum, result.machine};
}

std::array<std::uint64_t, 6> numbers_of(const StoredLease& stored) {
    const auto& [lease, worker, range] = stored.lease;
    return {lease, stored.job, worker, range.source, range.first, range.count};
}

std::uint64_t checksum(JobId job, const Snapshot& snapshot) {
    return checksum(
        std::array{job, snapshot.next_result, checksum(job, std::as_bytes(std::span(snapshot.file.bytes)))});
}

/// Numbers, and their checksum behind them.
Result<void> write_row(Statement& insert, std::span<const std::uint64_t> numbers) {
    for (const std::uint64_t number : numbers) insert.bind(number);
    return insert.bind(checksum(numbers)).run();
}

template <std::size_t n>
std::optional<std::array<std::uint64_t, n>> read_row(const Statement& row) {
    std::array<std::uint64_t, n> numbers;
    for (std::size_t i = 0; i < n; ++i) numbers[i] = row.number(static_cast<int>(i));
    if (row.number(n) != checksum(numbers)) return std::nullopt;
    return numbers;
}

std::vector<std::byte> encode(const JobRecord& record) {
    std::vector<std::byte> bytes;
    wire::OutputArchive archive(bytes);
    archive << record;
    return bytes;
}

std::optional<JobRecord> decode(JobId job, std::span<const std::byte> bytes) {
    wire::InputArchive archive(bytes);
    JobRecord record;
    archive >> record;
    archive.finish();
    if (archive.refused() || record.id() != job) return std::nullopt;
    return record;
}

}  // namespace

Result<JobStore> JobStore::open(const std::filesystem::path& file, const char* vfs) {
    auto database = Database::open(file, schema, vfs);
    if (!database) return database.error();
    return JobStore(std::move(*database));
}

Result<JobStore::Contents> JobStore::load() {
    // a record that can't be one is not even read
    auto rows = database_.prepare(
        "SELECT job, CASE WHEN length(record) <= ? THEN record ELSE x'' END, checksum FROM jobs ORDER BY job");
    if (!rows) return rows.error();
    rows->bind(limits::job_record_bytes_max);
    Contents contents;
    auto removed = database_.prepare("SELECT ifnull(max(last), 0) FROM removed");
    if (!removed) return removed.error();
    if (const auto row = removed->step(); !row) return row.error();
    contents.next_job = removed->number(0) + 1;
    while (true) {
        const auto row = rows->step();
        if (!row) return row.error();
        if (!*row) return contents;
        const JobId job = rows->number(0);
        contents.next_job = std::max(contents.next_job, job + 1);
        const std::vector<std::byte> bytes = rows->bytes(1);
        auto record = rows->number(2) == checksum(job, bytes) ? decode(job, bytes) : std::nullopt;
        if (record) {
            contents.records.push_back(std::move(*record));
        } else {
            contents.warnings.push_back("the record of job " + std::to_string(job) + " is damaged; it is left out");
        }
    }
}

Result<std::uint32_t> JobStore::begin_life() {
    auto lives = database_.prepare("SELECT begun, checksum FROM lives");
    if (!lives) return lives.error();
    const auto row = lives->step();
    if (!row) return row.error();
    std::uint32_t life = 0;
    if (*row) {
        life = static_cast<std::uint32_t>(lives->number(0));
        if (lives->number(1) != checksum_of_lives(life))
            return failed("the number of the master's lives is damaged in its database");
    }
    ++life;
    auto begin = database_.prepare("INSERT OR REPLACE INTO lives VALUES (1, ?, ?)");
    if (!begin) return begin.error();
    if (const auto begun = begin->bind(life).bind(checksum_of_lives(life)).run(); !begun) return begun.error();
    return life;
}

Result<void> JobStore::write_record(const JobRecord& record) {
    auto put = database_.prepare("INSERT OR REPLACE INTO jobs VALUES (?, ?, ?)");
    if (!put) return put.error();
    const std::vector<std::byte> bytes = encode(record);
    return put->bind(record.id()).bind(bytes).bind(checksum(record.id(), bytes)).run();
}

Result<void> JobStore::put(const JobRecord& record) { return write_record(record); }

/// `sql` has as many parameters as there are keys.
Result<void> JobStore::remove_rows(const char* sql, std::span<const std::uint64_t> keys) {
    auto remove = database_.prepare(sql);
    if (!remove) return remove.error();
    for (const std::uint64_t key : keys) remove->bind(key);
    return remove->run();
}

Result<void> JobStore::finish(const JobRecord& record) {
    auto all = database_.begin();
    if (!all) return all.error();
    if (auto written = write_record(record); !written) return written;
    for (const char* sql : {"DELETE FROM results WHERE job = ?", "DELETE FROM leases WHERE job = ?",
                            "DELETE FROM snapshots WHERE job = ?"})
        if (auto removed = remove_rows(sql, std::array{record.id()}); !removed) return removed;
    return all->commit();
}

Result<void> JobStore::commit(std::span<const StoredResult> results, std::span<const StoredLease> given,
                              std::span<const LeaseId> ended) {
    auto all = database_.begin();
    if (!all) return all.error();
    auto insert = database_.prepare("INSERT INTO results VALUES (?, ?, ?, ?, ?, ?, ?, ?)");
    if (!insert) return insert.error();
    for (const StoredResult& result : results)
        if (auto written = write_row(*insert, numbers_of(result)); !written) return written;
    auto lease = database_.prepare("INSERT OR REPLACE INTO leases VALUES (?, ?, ?, ?, ?, ?, ?)");
    if (!lease) return lease.error();
    for (const StoredLease& stored : given) {
        if (std::find(ended.begin(), ended.end(), stored.lease.lease) != ended.end()) continue;
        if (auto written = write_row(*lease, numbers_of(stored)); !written) return written;
    }
    for (const LeaseId id : ended)
        if (auto removed = remove_rows("DELETE FROM leases WHERE lease = ?", std::array{id}); !removed) return removed;
    return all->commit();
}

Result<void> JobStore::reopen(const JobRecord& record, const Digest& solution) {
    auto all = database_.begin();
    if (!all) return all.error();
    if (auto written = write_record(record); !written) return written;
    if (auto written = write_snapshot(record.id(), {solution, 0}); !written) return written;
    return all->commit();
}

Result<void> JobStore::remove(JobId job) {
    auto all = database_.begin();
    if (!all) return all.error();
    if (auto removed = remove_rows("DELETE FROM jobs WHERE job = ?", std::array{job}); !removed) return removed;
    auto note = database_.prepare("INSERT OR REPLACE INTO removed SELECT 1, max(?, ifnull(max(last), 0)) FROM removed");
    if (!note) return note.error();
    if (auto noted = note->bind(job).run(); !noted) return noted;
    return all->commit();
}

Result<void> JobStore::write_snapshot(JobId job, const Snapshot& snapshot) {
    auto put = database_.prepare("INSERT OR REPLACE INTO snapshots VALUES (?, ?, ?, ?)");
    if (!put) return put.error();
    const auto file = std::as_bytes(std::span(snapshot.file.bytes));
    return put->bind(job).bind(snapshot.next_result).bind(file).bind(checksum(job, snapshot)).run();
}

Result<void> JobStore::checkpoint(JobId job, const Snapshot& snapshot, bool keep_results, bool end_leases) {
    auto all = database_.begin();
    if (!all) return all.error();
    if (auto written = write_snapshot(job, snapshot); !written) return written;
    if (end_leases)
        if (auto removed = remove_rows("DELETE FROM leases WHERE job = ?", std::array{job}); !removed) return removed;
    if (keep_results) return all->commit();
    if (auto removed =
            remove_rows("DELETE FROM results WHERE job = ? AND number < ?", std::array{job, snapshot.next_result});
        !removed)
        return removed;
    return all->commit();
}

Result<void> JobStore::retract(const JobRecord& record, const std::set<MachineId>& machines, bool all_results) {
    const JobId job = record.id();
    auto all = database_.begin();
    if (!all) return all.error();
    if (auto written = write_record(record); !written) return written;
    if (auto removed = remove_rows("DELETE FROM snapshots WHERE job = ?", std::array{job}); !removed) return removed;
    for (const MachineId machine : machines)
        if (auto removed = remove_rows("DELETE FROM results WHERE job = ? AND machine = ?", std::array{job, machine});
            !removed)
            return removed;
    if (all_results)
        if (auto removed = remove_rows("DELETE FROM results WHERE job = ?", std::array{job}); !removed) return removed;
    return all->commit();
}

Result<JobStore::Unfinished> JobStore::unfinished(JobId job) {
    Unfinished unfinished;
    if (const auto read = read_snapshot(job, unfinished); !read) return read.error();
    if (const auto read = read_results(job, unfinished); !read) return read.error();
    if (const auto read = read_leases(job, unfinished); !read) return read.error();
    return unfinished;
}

Result<void> JobStore::read_snapshot(JobId job, Unfinished& into) {
    auto rows = database_.prepare("SELECT next_result, file, checksum FROM snapshots WHERE job = ?");
    if (!rows) return rows.error();
    const auto row = rows->bind(job).step();
    if (!row) return row.error();
    if (!*row) return {};
    Snapshot snapshot;
    snapshot.next_result = rows->number(0);
    const std::vector<std::byte> file = rows->bytes(1);
    std::transform(file.begin(), file.begin() + std::min<std::ptrdiff_t>(std::ssize(file), 32),
                   snapshot.file.bytes.begin(), [](std::byte byte) { return std::to_integer<std::uint8_t>(byte); });
    into.next_result = snapshot.next_result;
    if (rows->number(2) == checksum(job, snapshot)) {
        into.snapshot = snapshot;
    } else {
        ++into.damaged;
    }
    return {};
}

Result<void> JobStore::read_results(JobId job, Unfinished& into) {
    auto rows = database_.prepare("SELECT * FROM results WHERE job = ? ORDER BY number");
    if (!rows) return rows.error();
    rows->bind(job);
    while (true) {
        const auto row = rows->step();
        if (!row) return row.error();
        if (!*row) return {};
        into.next_result = std::max(into.next_result, rows->number(1) + 1);
        if (const auto n = read_row<7>(*rows)) {
            into.results.push_back({(*n)[0], (*n)[1], (*n)[2], (*n)[3], (*n)[4], (*n)[5], (*n)[6]});
        } else {
            ++into.damaged;
        }
    }
}

Result<void> JobStore::read_leases(JobId job, Unfinished& into) {
    auto rows = database_.prepare("SELECT * FROM leases WHERE job = ? ORDER BY lease");
    if (!rows) return rows.error();
    rows->bind(job);
    while (true) {
        const auto row = rows->step();
        if (!row) return row.error();
        if (!*row) return {};
        if (const auto n = read_row<6>(*rows)) {
            into.leases.push_back({(*n)[0], (*n)[2], {static_cast<std::uint32_t>((*n)[3]), (*n)[4], (*n)[5]}});
        } else {
            ++into.damaged_leases;
        }
    }
}

}  // namespace lumenfarm
