#include "master/job_log.h"

#include "common/scene/scene_file.h"
#include "master/result_bytes.h"
#include "master/snapshot_file.h"

#include <xxhash.h>

#include <charconv>
#include <limits>
#include <memory>
#include <span>
#include <utility>

namespace lumenfarm {

namespace {

/// XXH3-64 of bytes that come in pieces.
class Checksum {
public:
    Checksum() { XXH3_64bits_reset(state_.get()); }
    void add(std::span<const std::byte> bytes) { XXH3_64bits_update(state_.get(), bytes.data(), bytes.size()); }
    std::uint64_t value() const { return XXH3_64bits_digest(state_.get()); }

private:
    struct Free {
        void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
    };
    std::unique_ptr<XXH3_state_t, Free> state_{XXH3_createState()};
};

}  // namespace

JobLog::JobLog(Disk& disk, std::filesystem::path folder, const SnapshotRule& rule, const JobRecord& job,
               std::shared_ptr<const PreparedJob> prepared)
    : disk_(disk),
      folder_(std::move(folder)),
      rule_(rule),
      job_(job.id()),
      spec_(job.spec),
      scene_(job.status.scene),
      keeps_results_(job.audited),
      prepared_(std::move(prepared)) {}

std::filesystem::path JobLog::path(std::uint64_t segment) const {
    return folder_ / (std::to_string(job_) + "-" + std::to_string(segment));
}

Result<void> JobLog::find_segments() {
    const auto names = disk_.list(folder_);
    if (!names) return names.error();
    const std::string of_job = std::to_string(job_) + "-";
    for (const std::string& name : *names) {
        if (!name.starts_with(of_job)) continue;
        std::uint64_t segment = 0;
        const char* end = name.data() + name.size();
        const auto read = std::from_chars(name.data() + of_job.size(), end, segment);
        if (read.ec == std::errc() && read.ptr == end) segments_.insert(segment);
    }
    return {};
}

Result<std::vector<std::string>> JobLog::recover(const JobStore::Unfinished& kept, const FileStore& files) {
    recovered_ = false;
    if (const auto found = find_segments(); !found) return found.error();
    sums_.reset();  // before others are made: they may be the most of what the master has in memory
    sums_.emplace(spec_, prepared_);
    if (prepared_->subspaces) cut_ = prepared_->subspaces->partition();
    snapshot_.reset();
    last_snapshot_bytes_ = 0;
    cut_short_ = false;
    const auto is_cut_short = [&](const std::vector<std::string>& damages) {
        return spec_.strategy == Strategy::subspaces && !damages.empty();
    };
    kept_results_ = kept_bytes_ = 0;
    std::vector<std::string> damages;
    const std::string name = "job " + std::to_string(job_);
    if (kept.damaged > 0)
        damages.push_back(std::to_string(kept.damaged) + " rows of " + name + " are damaged in the database");
    if (kept.snapshot)
        if (const auto read = recover_snapshot(*kept.snapshot, files); !read) {
            if (read.error().code != ErrorCode::bad_input) return read.error();
            damages.push_back("the snapshot of " + name + " is lost: " + read.error().sentence);
        }
    for (const StoredResult& stored : kept.results) {
        if ((cut_short_ = is_cut_short(damages))) break;
        if (snapshot_ && stored.number < kept.snapshot->next_result) continue;
        if (const auto read = recover_result(stored); !read) {
            if (read.error().code != ErrorCode::bad_input) return read.error();
            damages.push_back("result " + std::to_string(stored.number) + " of " + name +
                              " is lost: " + read.error().sentence);
        }
    }
    cut_short_ = is_cut_short(damages);
    if (kept.damaged_leases > 0)
        damages.push_back(std::to_string(kept.damaged_leases) + " leases of " + name + " are damaged in the database");
    next_result_ = kept.next_result;
    recovered_ = true;
    return damages;
}

Result<void> JobLog::recover_snapshot(const Snapshot& snapshot, const FileStore& files) {
    const auto bytes = files.read(snapshot.file);
    if (!bytes) return bytes.error();
    auto read = decode_snapshot(*bytes, *prepared_, scene_);
    if (!read) return read.error();
    const JobSpec& its = read->solution.spec;
    if (!same_but_for_particles(its, spec_) || its.particles > spec_.particles)
        return bad_input("it is of another job");
    sums_->restore(std::move(read->solution), std::move(read->flights), std::move(read->ended),
                   std::move(read->work_times));
    if (!read->cut.nodes().empty()) cut_ = std::move(read->cut);
    snapshot_ = snapshot.file;
    last_snapshot_bytes_ = bytes->size();
    return {};
}

LearnedCut JobLog::learned_cut(double above) const {
    return learn_cut(*prepared_, cut_, sums_->sums().texels(), sums_->work_times(), above);
}

void JobLog::cut_by(LearnedCut learned) {
    sums_->file_by(learned.cut, std::move(learned.lesson));
    cut_ = std::move(learned.cut);
}

Result<void> JobLog::recover_result(const StoredResult& stored) {
    const auto bytes = read_segment(disk_, path(stored.segment), stored.offset, stored.bytes);
    if (!bytes) return bytes.error();
    if (XXH3_64bits(bytes->data(), bytes->size()) != stored.checksum)
        return bad_input("'" + path(stored.segment).string() + "' is damaged at byte " + std::to_string(stored.offset));
    const auto result = decode_result(*bytes, job_, spec_, *prepared_);
    if (!result) return result.error();
    if (!sums_->fits(*result)) return bad_input("its particles were merged already");
    sums_->merge(*result);
    ++kept_results_;
    kept_bytes_ += stored.bytes;
    return {};
}

Result<StoredResult> JobLog::append(const StagedResult& result, MachineId machine) {
    if (!segment_) {
        const std::uint64_t number = segments_.empty() ? 0 : *segments_.rbegin() + 1;
        auto made = Segment::make(disk_, path(number));
        if (!made) return made.error();
        segment_ = std::move(*made);
        segments_.insert(number);
    }
    const std::uint64_t offset = segment_->bytes();
    Checksum checksum;
    const auto written = encode_result(result, [&](std::span<const std::byte> frame) {
        checksum.add(frame);
        return segment_->append(frame);
    });
    if (!written) return written.error();
    const std::uint64_t bytes = segment_->bytes() - offset;
    ++appended_results_;
    appended_bytes_ += bytes;
    return StoredResult{job_, next_result_++, *segments_.rbegin(), offset, bytes, checksum.value(), machine};
}

Result<void> JobLog::sync() { return segment_ ? segment_->sync() : Result<void>(); }

void JobLog::keep() {
    if (segment_) segment_->keep();
    kept_results_ += std::exchange(appended_results_, 0);
    kept_bytes_ += std::exchange(appended_bytes_, 0);
}

Result<void> JobLog::undo() {
    next_result_ -= std::exchange(appended_results_, 0);
    appended_bytes_ = 0;
    return segment_ ? segment_->undo() : Result<void>();
}

EncodedSolution JobLog::solution(const JobEffort& effort) {
    Solution solution = sums_->take(scene_);
    solution.time.total_s = effort.elapsed_s;
    solution.time.workers = effort.workers;
    EncodedSolution encoded = encode_solution(solution);
    sums_->restore(std::move(solution));
    return encoded;
}

std::vector<std::byte> JobLog::snapshot_bytes(const JobEffort& effort) {
    return encode_snapshot(solution(effort).bytes, cut_, sums_->work_times(), sums_->flights(), sums_->ended());
}

bool JobLog::snapshot_pays(std::uint64_t coming_bytes, bool disk_is_full) const {
    if (!has_news()) return false;
    const auto asked = disk_.free_bytes(folder_);
    const std::uint64_t free_bytes = asked ? *asked : std::numeric_limits<std::uint64_t>::max();
    if (free_bytes < snapshot_awaits_bytes_) return false;
    const std::uint64_t sum_bytes = sums_->bytes();
    const bool makes_room = !keeps_results_;
    if (rule_.pays(kept_results_, kept_bytes_, sum_bytes)) return makes_room || !disk_is_full;
    return makes_room && SnapshotRule::makes_room_in_time(kept_bytes_, sum_bytes, last_snapshot_bytes_, coming_bytes,
                                                          disk_is_full ? 0 : free_bytes);
}

Result<void> JobLog::begin_after(const Digest& snapshot, std::uint64_t its_bytes) {
    snapshot_ = snapshot;
    last_snapshot_bytes_ = its_bytes;
    snapshot_awaits_bytes_ = 0;
    cut_short_ = false;
    kept_results_ = kept_bytes_ = 0;
    return keeps_results_ ? Result<void>() : begin_segments_anew();
}

Result<void> JobLog::begin_segments_anew() {
    const std::uint64_t last = segments_.empty() ? 0 : *segments_.rbegin();
    auto removed = remove_segments();
    segments_.insert(last);  // its number is not used again
    return removed;
}

Result<void> JobLog::remove_segments() {
    segment_.reset();
    for (const std::uint64_t segment : segments_)
        if (auto removed = disk_.remove(path(segment)); !removed) return removed;
    segments_.clear();
    return {};
}

}  // namespace lumenfarm
