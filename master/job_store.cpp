#include "master/job_store.h"

#include "common/support/file.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <string_view>
#include <system_error>

namespace lumenfarm {

namespace {

constexpr std::string_view format_line = "lumenfarm job 1\n";

std::vector<std::byte> encode(const JobRecord& record) {
    std::vector<std::byte> bytes(format_line.size());
    std::memcpy(bytes.data(), format_line.data(), format_line.size());
    wire::OutputArchive archive(bytes);
    archive << record;
    return bytes;
}

Result<JobRecord> decode(const std::filesystem::path& path) {
    const auto bytes = read_file(path, limits::job_record_bytes_max);
    if (!bytes) return bytes.error();
    const bool ours =
        bytes->size() >= format_line.size() && std::memcmp(bytes->data(), format_line.data(), format_line.size()) == 0;
    if (!ours) return failed("'" + path.string() + "' is not the record of a job");
    const std::span<const std::byte> rest(*bytes);
    wire::InputArchive archive(rest.subspan(format_line.size()));
    JobRecord record;
    archive >> record;
    archive.finish();
    if (archive.refused()) return failed("the record of a job in '" + path.string() + "' is damaged");
    return record;
}

}  // namespace

Result<void> FolderJobStore::put(const JobRecord& record) {
    return write_file(folder_ / (std::to_string(record.id()) + ".job"), encode(record));
}

Result<JobStore::Contents> FolderJobStore::load() {
    if (const auto made = make_folder(folder_); !made) return made.error();
    Contents contents;
    std::error_code error;
    for (std::filesystem::directory_iterator at(folder_, error), end; !error && at != end; at.increment(error)) {
        if (at->path().extension() != ".job") continue;
        auto record = decode(at->path());
        if (record) {
            contents.records.push_back(std::move(*record));
        } else {
            contents.warnings.push_back(record.error().sentence);
        }
    }
    if (error) return failed("can't read the folder '" + folder_.string() + "': " + error.message());
    std::sort(contents.records.begin(), contents.records.end(),
              [](const JobRecord& a, const JobRecord& b) { return a.id() < b.id(); });
    return contents;
}

Result<std::uint32_t> FolderJobStore::begin_life() {
    const std::filesystem::path path = folder_ / "lives";
    std::uint32_t lives = 0;
    if (std::filesystem::exists(path)) {
        const auto bytes = read_file(path, 16);
        if (!bytes) return bytes.error();
        const auto* text = reinterpret_cast<const char*>(bytes->data());
        std::from_chars(text, text + bytes->size(), lives);
    }
    if (const auto written = write_file(path, std::to_string(++lives)); !written) return written.error();
    return lives;
}

}  // namespace lumenfarm
