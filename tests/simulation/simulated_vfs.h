#pragma once

#include "master/disk/disk.h"

#include <memory>

namespace lumenfarm::testing {

struct VfsState;

/// Puts SQLite's files on a Disk: Database::open(file, schema, vfs.name()). One program, one connection to a file, with
/// locking_mode=EXCLUSIVE: there are no locks and no shared memory. It promises SQLite nothing that a disk need not do
/// but what SQLite takes for granted on its own systems: a write harms no bytes beside it. It has no clock, and gives
/// SQLite's random numbers a seed while it lives. Not thread-safe.
class SimulatedVfs {
public:
    /// The disk must stay.
    explicit SimulatedVfs(Disk& disk, int seed = 1);
    ~SimulatedVfs();  ///< REQUIRES: every database on it is closed
    SimulatedVfs(const SimulatedVfs&) = delete;
    SimulatedVfs& operator=(const SimulatedVfs&) = delete;

    const char* name() const;  ///< of this one only

private:
    std::unique_ptr<VfsState> state_;
};

}  // namespace lumenfarm::testing
