#pragma once

#include "master/commit_queue.h"
#include "master/disk/file_store.h"
#include "master/effects.h"
#include "master/job_log.h"
#include "master/job_store.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

/// Carries out the master's slow effects, on one thread at a time of the caller's choice. Errors everywhere: no_space,
/// after which the same may be tried again; failed: of the disk. After a write that failed nobody knows what is on the
/// disk, so everything fails from then on (broken()), and the next life of the master finds out.
namespace lumenfarm {

class Storage {
public:
    /// FOLDER/files, FOLDER/segments, FOLDER/jobs.sqlite. The disk must stay. `vfs`: as Database::open().
    static Result<std::unique_ptr<Storage>> open(Disk& disk, const std::filesystem::path& folder,
                                                 const char* vfs = nullptr, const SnapshotRule& rule = {});

    /// The jobs of earlier lives, and what begins with this one. To be called once, first. Removes what no job needs.
    struct Start {
        std::vector<JobRecord> records;
        JobId next_job = 1;
        std::uint32_t life = 1;             ///< this one, from 1 on
        std::vector<std::string> warnings;  ///< what is damaged
    };
    Result<Start> start();

    /// Answers Admit: the chunks to be uploaded first; or none, the scene being good for the job and `record` stored.
    /// Errors also: bad_input (the scene or the job).
    Result<std::vector<std::uint32_t>> admit(const Admit& admit);
    /// Errors also: bad_input, failed (the scene is damaged).
    Result<RecoveredJob> prepare(const Prepare& prepare);
    /// REQUIRES: the job is prepared, and has subspaces.
    Evenness measure(const MeasureCut& effect) const;

    /// Leases of jobs that are over are left out. Gives what became of each job that has results in it.
    Result<std::map<JobId, Merged>> commit(const CommitBatch& batch);
    Result<void> put(const StoreRecord& store);
    /// A snapshot that finds no room is left out.
    Result<void> put_aside(const PutAside& aside);
    Result<void> remove(const RemoveJob& remove);
    Result<Retracted> retract(const Retract& retract);
    /// Whether one was worth its writing.
    Result<bool> store(const StoreSnapshot& snapshot);
    /// The record as it was stored.
    Result<JobRecord> store(const StoreSolution& solution);
    /// Errors also: bad_input, as FileStore::put_chunk().
    Result<void> put_chunk(const wire::Chunk& chunk);
    Result<Digest> put_scene(std::span<const std::byte> bytes);

    wire::Message serve(const ServeManifest& serve) { return files_.answer(wire::ManifestRequest(serve.file)); }
    wire::Message serve(const ServeChunk& serve) const {
        return files_.answer(wire::ChunkRequest(serve.file, serve.index));
    }

    FileStore& files() { return files_; }
    const std::optional<Error>& broken() const { return broken_; }

private:
    Storage(Disk& disk, const std::filesystem::path& folder, JobStore jobs, const SnapshotRule& rule);
    Result<void> sweep(const Start& start);
    Result<void> finish(const JobRecord& record);
    /// `end_leases`: what is in flight has other numbers than when they were given.
    Result<void> snapshot(JobLog& log, JobId job, const JobEffort& effort, bool end_leases = false);
    Result<std::shared_ptr<const PreparedJob>> prepared(const JobRecord& job);
    static std::optional<Evenness> cut_anew_if_uneven(JobLog& log, double above);
    Result<WorkerFiles> files_for_workers(const JobRecord& job, const PreparedJob& prepared, const Partition& cut);
    Result<void> end_log(std::map<JobId, JobLog>::iterator log);
    Result<std::vector<StoredResult>> write(const CommitBatch& batch);
    Result<void> commit(const CommitBatch& batch, const std::vector<StoredResult>& rows);
    /// Hands a result of the disk through, and remembers when it is broken.
    template <class T>
    Result<T> watched(Result<T> result);

    Disk& disk_;
    std::filesystem::path segments_;
    FileStore files_;
    JobStore jobs_;
    SnapshotRule rule_;
    std::map<JobId, JobLog> logs_;
    std::map<JobId, WorkerFiles> worker_files_;
    std::optional<Error> broken_;
    Digest admitted_scene_;  ///< of admitted_, which the next prepare() will most likely ask for
    JobSpec admitted_spec_;
    std::shared_ptr<const PreparedJob> admitted_;
};

}  // namespace lumenfarm
