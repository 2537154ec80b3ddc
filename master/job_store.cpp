#include "master/job_store.h"

#include <xxhash.h>

#include <array>
#include <optional>
#include <utility>

namespace lumenfarm {

namespace {

// docs/operations.md, "The storage folder". Checksums are XXH3-64, that of a record is seeded with the job: SQLite
// verifies its own structure, not the bytes of a row.
constexpr std::array schema{
    "CREATE TABLE jobs (job INTEGER PRIMARY KEY, record BLOB NOT NULL, checksum INTEGER NOT NULL) STRICT;"
    "CREATE TABLE lives (one INTEGER PRIMARY KEY CHECK (one = 1), begun INTEGER NOT NULL,"
    " checksum INTEGER NOT NULL) STRICT;"};

std::uint64_t checksum(JobId job, std::span<const std::byte> record) {
    return XXH3_64bits_withSeed(record.data(), record.size(), job);
}

std::uint64_t checksum_of_lives(std::uint32_t begun) { return XXH3_64bits(&begun, sizeof begun); }

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

Result<void> JobStore::put(const JobRecord& record) {
    auto put = database_.prepare("INSERT OR REPLACE INTO jobs VALUES (?, ?, ?)");
    if (!put) return put.error();
    const std::vector<std::byte> bytes = encode(record);
    return put->bind(record.id()).bind(bytes).bind(checksum(record.id(), bytes)).run();
}

Result<JobStore::Contents> JobStore::load() {
    // a record that can't be one is not even read
    auto rows = database_.prepare(
        "SELECT job, CASE WHEN length(record) <= ? THEN record ELSE x'' END, checksum FROM jobs ORDER BY job");
    if (!rows) return rows.error();
    rows->bind(limits::job_record_bytes_max);
    Contents contents;
    while (true) {
        const auto row = rows->step();
        if (!row) return row.error();
        if (!*row) return contents;
        const JobId job = rows->number(0);
        contents.next_job = job + 1;
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

}  // namespace lumenfarm
