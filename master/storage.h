#pragma once

#include "master/effects.h"
#include "master/disk/file_store.h"
#include "master/job_store.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

/// Carries out the master's slow effects, on one thread at a time of the caller's choice.
namespace lumenfarm {

class Storage {
public:
    Storage(FileStore& files, JobStore& jobs) : files_(files), jobs_(jobs) {}

    /// Answers Admit: the chunks to be uploaded first; or none, the scene being good for the job and `record` stored.
    /// Errors: bad_input (the scene or the job), failed (disk).
    Result<std::vector<std::uint32_t>> admit(const Admit& admit);
    Result<std::shared_ptr<const PreparedJob>> prepare(const Prepare& prepare);
    Result<StoredSolution> store(const StoreSolution& solution);
    /// The reply to a request for a file: Manifest, Chunk or Refusal.
    wire::Message serve(const ServeManifest& serve);
    wire::Message serve(const ServeChunk& serve) const;

    FileStore& files() { return files_; }
    JobStore& jobs() { return jobs_; }

private:
    FileStore& files_;
    JobStore& jobs_;
    Digest admitted_scene_;  ///< of admitted_, which the next prepare() will most likely ask for
    JobSpec admitted_spec_;
    std::shared_ptr<const PreparedJob> admitted_;
};

}  // namespace lumenfarm
