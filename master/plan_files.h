#pragma once

#include "master/disk/file_store.h"
#include "master/recovered_job.h"

/// The files that workers of the object-space strategy fetch in place of the scene. They last as long as the job is
/// active; each life of the master makes them anew, the same to the bit.
namespace lumenfarm {

/// Puts the plan of a job and a part for each subspace of the cut. REQUIRES: the job has as many subspaces. Errors:
/// no_space, failed.
Result<WorkerFiles> put_plan(FileStore& files, const JobRecord& job, const PreparedJob& prepared, const Partition& cut);

}  // namespace lumenfarm
