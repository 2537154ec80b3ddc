#include "master/storage.h"

#include "common/support/ensure.h"
#include "master/learned_cut.h"
#include "master/plan_files.h"

#include <set>
#include <utility>

namespace lumenfarm {

Storage::Storage(Disk& disk, const std::filesystem::path& folder, JobStore jobs, const SnapshotRule& rule)
    : disk_(disk),
      segments_(folder / "segments"),
      files_(disk, folder / "files"),
      jobs_(std::move(jobs)),
      rule_(rule) {}

Result<std::unique_ptr<Storage>> Storage::open(Disk& disk, const std::filesystem::path& folder, const char* vfs,
                                               const SnapshotRule& rule) {
    if (const auto made = disk.make_folder(folder / "segments"); !made) return made.error();
    auto jobs = JobStore::open(folder / "jobs.sqlite", vfs);
    if (!jobs) return jobs.error();
    std::unique_ptr<Storage> storage(new Storage(disk, folder, std::move(*jobs), rule));
    if (const auto opened = storage->files_.open(); !opened) return opened.error();
    return storage;
}

template <class T>
Result<T> Storage::watched(Result<T> result) {
    if (!result && result.error().code == ErrorCode::failed && !broken_) broken_ = result.error();
    return result;
}

Result<Storage::Start> Storage::start() {
    auto contents = jobs_.load();
    if (!contents) return contents.error();
    Start start{std::move(contents->records), contents->next_job, 1, std::move(contents->warnings)};
    if (const auto swept = sweep(start); !swept) return swept.error();
    const auto life = jobs_.begin_life();
    if (!life) return life.error();
    start.life = *life;
    return start;
}

/// Removes files that no record names: of uploads without a job, or left by a life that ended in between. While a
/// record or row is damaged nothing is removed, since it may name any of them.
Result<void> Storage::sweep(const Start& start) {
    bool damaged = !start.warnings.empty();
    std::set<Digest> needed;
    std::set<std::string> running;
    for (const JobRecord& record : start.records) {
        needed.insert(record.status.scene);
        if (record.has_solution) needed.insert(record.solution_file);
        if (record.over()) continue;
        running.insert(std::to_string(record.id()));
        const auto kept = jobs_.unfinished(record.id());
        if (!kept) return kept.error();
        if (kept->snapshot) needed.insert(kept->snapshot->file);
        damaged = damaged || kept->damaged > 0 || kept->damaged_leases > 0;
    }
    if (damaged) return {};
    if (const auto removed = files_.remove_others(needed); !removed) return removed.error();
    const auto segments = disk_.list(segments_);
    if (!segments) return segments.error();
    for (const std::string& name : *segments)
        if (!running.contains(name.substr(0, name.find('-'))))
            if (auto removed = disk_.remove(segments_ / name); !removed) return removed;
    return {};
}

Result<std::vector<std::uint32_t>> Storage::admit(const Admit& admit) {
    if (broken_) return *broken_;
    auto missing = watched(files_.missing(admit.submit.scene));
    if (!missing || !missing->empty()) return missing;
    const auto bytes = files_.read(admit.submit.scene.file);
    if (!bytes && bytes.error().code != ErrorCode::bad_input) return bytes.error();
    if (!bytes) {
        // damaged since it came: it is sent again
        if (const auto removed = watched(files_.remove(admit.submit.scene.file)); !removed) return removed.error();
        return watched(files_.missing(admit.submit.scene));
    }
    auto prepared = prepare_job(admit.submit.spec, *bytes);
    if (!prepared) return prepared.error();
    if (const auto stored = watched(jobs_.put(admit.record)); !stored) return stored.error();
    admitted_scene_ = admit.submit.scene.file;
    admitted_spec_ = admit.submit.spec;
    admitted_ = *prepared;
    return missing;
}

Result<std::shared_ptr<const PreparedJob>> Storage::prepared(const JobRecord& job) {
    const auto admitted = std::exchange(admitted_, nullptr);
    if (admitted && admitted_scene_ == job.status.scene && admitted_spec_ == job.spec) return admitted;
    const auto bytes = files_.read(job.status.scene);
    if (!bytes) return bytes.error();
    return prepare_job(job.spec, *bytes);
}

Result<RecoveredJob> Storage::prepare(const Prepare& prepare) {
    if (broken_) return *broken_;
    const JobRecord& job = prepare.job;
    auto ready = prepared(job);
    if (!ready) return ready.error();
    auto kept = watched(jobs_.unfinished(job.id()));
    if (!kept) return kept.error();
    JobLog& log = logs_.try_emplace(job.id(), disk_, segments_, rule_, job, *ready).first->second;
    auto damages = log.recover(*kept, files_);
    if (!damages) {
        // what can't be read holds back this job, not the others
        logs_.erase(job.id());
        return damages.error();
    }
    // what was left out is not to be found again
    const JobEffort effort{log.sums().time().total_s, log.sums().time().workers};
    const bool may_learn =
        (*ready)->subspaces && prepare.recut_above && log.sums().balance().hits >= prepare.recut_hits;
    const auto recut = may_learn ? cut_anew_if_uneven(log, *prepare.recut_above) : std::nullopt;
    auto files = files_for_workers(job, **ready, log.cut());
    const bool renumbered = log.cut_short() || recut;
    const auto settled = files && renumbered ? snapshot(log, job.id(), effort, true) : Result<void>();
    if (!files || !settled) {
        logs_.erase(job.id());
        return files ? settled.error() : files.error();
    }
    const JobSums& sums = log.sums();
    RecoveredJob recovered;
    recovered.prepared = std::move(*ready);
    recovered.files = std::move(*files);
    recovered.committed = sums.committed();
    recovered.committed.insert(recovered.committed.end(), sums.ended().begin(), sums.ended().end());
    recovered.flights = sums.flights();
    recovered.balance = sums.balance();
    recovered.trace_cpu_s = sums.time().trace_s;
    recovered.effort = effort;
    recovered.keep_threshold = sums.keep_threshold();
    recovered.leases = std::move(kept->leases);
    recovered.damages = std::move(*damages);
    recovered.recut = recut;
    return recovered;
}

std::optional<Evenness> Storage::cut_anew_if_uneven(JobLog& log, double above) {
    LearnedCut learned = log.learned_cut(above);
    if (!learned.evenness.is_worth_a_cut(above)) return std::nullopt;
    const Evenness evenness = learned.evenness;
    log.cut_by(std::move(learned));
    return evenness;
}

Evenness Storage::measure(const MeasureCut& effect) const {
    const auto log = logs_.find(effect.job);
    if (log == logs_.end()) return {};
    return log->second.learned_cut(effect.above).evenness;
}

/// The scene, or what stands for it.
Result<WorkerFiles> Storage::files_for_workers(const JobRecord& job, const PreparedJob& prepared,
                                               const Partition& cut) {
    if (!prepared.subspaces) return WorkerFiles{job.status.scene, job.scene_bytes, {}};
    auto files = watched(put_plan(files_, job, prepared, cut));
    if (files) worker_files_[job.id()] = *files;
    return files;
}

/// Nothing of the job is in memory any more, and workers need nothing of it.
Result<void> Storage::end_log(std::map<JobId, JobLog>::iterator log) {
    const JobId job = log->first;
    logs_.erase(log);
    const auto own = worker_files_.extract(job);
    if (own.empty()) return {};
    std::set<Digest> files{own.mapped().first};
    for (const PartFile& part : own.mapped().parts) files.insert(part.file);
    for (const auto& [other, theirs] : worker_files_) {
        files.erase(theirs.first);
        for (const PartFile& part : theirs.parts) files.erase(part.file);
    }
    for (const Digest& file : files)
        if (auto removed = watched(files_.remove(file)); !removed) return removed;
    return {};
}

/// Results first, to be found where the rows will say that they are.
Result<std::vector<StoredResult>> Storage::write(const CommitBatch& batch) {
    std::vector<StoredResult> rows;
    std::set<JobId> jobs;
    for (const StoreResult& each : batch.results) {
        auto row = logs_.at(each.job).append(*each.result, each.machine);
        if (!row) return row.error();
        rows.push_back(*row);
        jobs.insert(each.job);
    }
    for (const JobId job : jobs)
        if (const auto synced = logs_.at(job).sync(); !synced) return synced.error();
    return rows;
}

Result<void> Storage::commit(const CommitBatch& batch, const std::vector<StoredResult>& rows) {
    std::vector<StoredLease> given;
    for (const StoredLease& lease : batch.leases.given)
        if (logs_.contains(lease.job)) given.push_back(lease);
    return jobs_.commit(rows, given, batch.leases.ended);
}

Result<std::map<JobId, Merged>> Storage::commit(const CommitBatch& batch) {
    if (broken_) return *broken_;
    const auto rows = watched(write(batch));
    const auto committed = rows ? watched(commit(batch, *rows)) : Result<void>(rows.error());
    if (!committed && committed.error().code == ErrorCode::failed) {
        // nobody knows whether it counts: the next life may find the rows, and must find the bytes
        return committed.error();
    }
    if (!committed) {
        for (auto& [job, log] : logs_)
            if (const auto undone = watched(log.undo()); !undone) return undone.error();
        return committed.error();
    }
    std::map<JobId, Merged> merged;
    for (auto& [job, log] : logs_) log.keep();
    for (const StoreResult& each : batch.results) {
        JobLog& log = logs_.at(each.job);
        Merged& job = merged[each.job];
        for (FlightQueues::Filed& filed : log.merge(*each.result)) job.filed.push_back(std::move(filed));
        job.keep_threshold = log.sums().keep_threshold();
    }
    return merged;
}

Result<void> Storage::put(const StoreRecord& store) {
    if (broken_) return *broken_;
    const JobRecord& record = store.record;
    if (store.basis) return watched(jobs_.reopen(record, *store.basis));
    // a job that never ran, or failed, has nothing to be fetched
    return record.over() && !record.has_solution ? finish(record) : watched(jobs_.put(record));
}

Result<void> Storage::finish(const JobRecord& record) {
    if (auto finished = watched(jobs_.finish(record)); !finished) return finished;
    const auto log = logs_.find(record.id());
    if (log == logs_.end()) return {};
    if (auto removed = watched(log->second.remove_segments()); !removed) return removed;
    return end_log(log);
}

Result<bool> Storage::store(const StoreSnapshot& effect) {
    if (broken_) return *broken_;
    const auto found = logs_.find(effect.job);
    if (found == logs_.end()) return false;
    JobLog& log = found->second;
    std::uint64_t coming_bytes = 0;
    for (const auto& [job, each] : logs_) coming_bytes += each.kept_bytes();
    if (!(effect.last ? log.has_news() : log.snapshot_pays(coming_bytes, effect.disk_is_full))) return false;
    if (const auto stored = snapshot(log, effect.job, effect.effort); !stored) return stored.error();
    return true;
}

Result<void> Storage::snapshot(JobLog& log, JobId job, const JobEffort& effort, bool end_leases) {
    const std::vector<std::byte> bytes = log.snapshot_bytes(effort);
    const auto file = watched(files_.put(bytes));
    if (!file) {
        log.snapshot_found_no_room(bytes.size());
        return file.error();
    }
    const auto older = log.snapshot();
    const Snapshot row{*file, log.next_result()};
    if (auto stored = watched(jobs_.checkpoint(job, row, log.keeps_results(), end_leases)); !stored) {
        if (!broken_ && older != *file) (void)watched(files_.remove(*file));
        return stored;
    }
    if (older && *older != *file)
        if (auto removed = watched(files_.remove(*older)); !removed) return removed;
    return watched(log.begin_after(*file, bytes.size()));
}

Result<void> Storage::put_aside(const PutAside& aside) {
    if (broken_) return *broken_;
    const auto found = logs_.find(aside.job);
    ensure(found != logs_.end(), "a job that is put aside has run");
    const auto kept = found->second.has_news() ? snapshot(found->second, aside.job, aside.effort) : Result<void>();
    if (!kept && kept.error().code != ErrorCode::no_space) return kept;
    return end_log(found);
}

Result<Retracted> Storage::retract(const Retract& effect) {
    if (broken_) return *broken_;
    const JobId job = effect.record.id();
    JobLog& log = logs_.at(job);
    const auto snapshot = log.snapshot();
    if (const auto done = watched(jobs_.retract(effect.record, effect.machines, effect.all)); !done)
        return done.error();
    if (snapshot)
        if (const auto removed = watched(files_.remove(*snapshot)); !removed) return removed.error();
    const auto kept = watched(jobs_.unfinished(job));
    if (!kept) return kept.error();
    if (const auto damages = watched(log.recover(*kept, files_)); !damages) return damages.error();
    if (kept->results.empty())
        if (const auto begun = watched(log.begin_segments_anew()); !begun) return begun.error();
    const JobSums& sums = log.sums();
    return Retracted{sums.committed(), sums.balance(), sums.time().trace_s, sums.keep_threshold()};
}

Result<void> Storage::remove(const RemoveJob& remove) {
    if (broken_) return *broken_;
    if (auto removed = watched(jobs_.remove(remove.job)); !removed) return removed;
    for (const Digest& file : remove.files)
        if (auto removed = watched(files_.remove(file)); !removed) return removed;
    return {};
}

Result<JobRecord> Storage::store(const StoreSolution& effect) {
    if (broken_) return *broken_;
    const auto found = logs_.find(effect.record.id());
    ensure(found != logs_.end(), "a job that ends has run");
    JobLog& log = found->second;
    const EncodedSolution solution = log.solution(effect.effort);
    const auto file = watched(files_.put(solution.bytes));
    if (!file) return file.error();
    JobRecord record = effect.record;
    record.status.state = record.complete ? wire::JobState::done : wire::JobState::cancelled;
    record.status.digest = solution.digest;
    record.solution_file = *file;
    record.has_solution = true;
    record.solution_bytes = solution.bytes.size();
    if (const auto stored = watched(jobs_.finish(record)); !stored) return stored.error();
    const auto snapshot = log.snapshot();
    if (snapshot && *snapshot != *file)
        if (const auto removed = watched(files_.remove(*snapshot)); !removed) return removed.error();
    if (const auto removed = watched(log.remove_segments()); !removed) return removed.error();
    if (const auto ended = end_log(found); !ended) return ended.error();
    return record;
}

Result<void> Storage::put_chunk(const wire::Chunk& chunk) {
    if (broken_) return *broken_;
    return watched(files_.put_chunk(chunk));
}

Result<Digest> Storage::put_scene(std::span<const std::byte> bytes) {
    if (broken_) return *broken_;
    return watched(files_.put(bytes));
}

}  // namespace lumenfarm
