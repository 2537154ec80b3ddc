#pragma once

#include "master/effects.h"
#include "master/set_sizer.h"
#include "master/staged_result.h"

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <variant>

/// What the master knows of one connection.
namespace lumenfarm {

/// Connected, and its Hello is due.
struct Greeting {};

struct Submitter {};

/// Subspaces whose triangles a worker has, and for how many more triangles it has memory.
struct Parts {
    std::set<std::uint32_t> held;
    std::uint64_t room_triangles = 0;
    bool all = false;  ///< nothing goes on elsewhere
};

struct Worker {
    std::uint32_t wanted = 0;        ///< sets that it has room for
    std::uint64_t leases_given = 0;  ///< in this session
    std::uint32_t threads_per_set = 1;
    bool leases_stated = false;     ///< its first Progress has come
    std::map<LeaseId, JobId> held;  ///< leases it stated when it came
    std::set<JobId> awaited;        ///< jobs of those that do not run yet
    std::set<JobId> told;           ///< jobs it has a JobInfo of
    std::set<JobId> declined;       ///< jobs it can't do
    std::optional<StagedResult> open;
    JobId job = 0;                 ///< of its newest lease
    LeaseId alone = 0;             ///< a lease beside which it gets nothing else, while it lasts
    std::map<JobId, Pace> paces;   ///< by job
    std::map<JobId, Parts> parts;  ///< strategy subspaces
    std::uint64_t particles = 0;
    std::uint32_t invalid_results = 0;

    /// A lease of the job is sent.
    void count_lease(JobId of_job) {
        --wanted;
        ++leases_given;
        job = of_job;
    }
};

struct Session {
    SessionId id = 0;
    std::string address;
    double connected_s = 0;
    double heard_s = 0;
    wire::Hello hello;
    std::variant<Greeting, Submitter, Worker> role;

    Worker* worker() { return std::get_if<Worker>(&role); }
    const Worker* worker() const { return std::get_if<Worker>(&role); }
    WorkerId instance() const { return hello.instance; }
    bool is_relay() const { return hello.role == wire::Role::relay; }
    MachineId machine() const;  ///< of its name, and its address without the port
};

}  // namespace lumenfarm
