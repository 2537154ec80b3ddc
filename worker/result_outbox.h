#pragma once

#include "common/support/limits.h"
#include "worker/parcel.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <optional>

/// Results on their way to the master, until it has answered. They are sent one after the other, as far as the master's
/// credit goes, and again from the start over a new connection.
namespace lumenfarm::worker {

class ResultOutbox {
public:
    void add(Parcel parcel);
    /// The next part of the oldest result that may go. `credit`: results under way, at most. `may_go`: whether the
    /// master is ready for results of a job.
    std::optional<wire::Message> next(std::uint32_t credit, const std::function<bool(JobId)>& may_go);
    /// The connection is lost.
    void rewind();

    /// The result that the master has answered, which is gone then; null: nobody asked.
    std::unique_ptr<const Parcel> take(std::uint64_t number);
    /// How many there were of the job.
    std::size_t drop(JobId job);

    std::size_t size() const { return results_.size(); }
    bool empty() const { return results_.empty(); }
    std::size_t bytes() const;
    bool has(JobId job) const;
    bool claims(std::uint64_t lease) const;
    /// Leases that results claim, and their jobs.
    std::map<std::uint64_t, JobId> leases() const;

private:
    struct Outgoing {
        std::uint64_t number = 0;
        std::unique_ptr<const Parcel> parcel;
        ParcelReader reader;
    };

    std::list<Outgoing> results_;  ///< oldest first
    std::uint64_t results_made_ = 0;
};

}  // namespace lumenfarm::worker
