#pragma once

#include "master/effects.h"

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

/// What is to be committed to the disk, in batches: one is on its way at a time, and what comes meanwhile makes the
/// next, so that a slow disk has larger ones.
namespace lumenfarm {

/// All of it is committed, or nothing.
struct CommitBatch {
    std::vector<StoreResult> results;
    StoreLeases leases;

    std::vector<std::uint64_t> tickets() const {
        std::vector<std::uint64_t> tickets;
        for (const StoreResult& result : results) tickets.push_back(result.ticket);
        return tickets;
    }
};

class CommitQueue {
public:
    void add(StoreResult result) { next_.results.push_back(std::move(result)); }
    void add(const StoreLeases& leases) {
        next_.leases.given.insert(next_.leases.given.end(), leases.given.begin(), leases.given.end());
        next_.leases.ended.insert(next_.leases.ended.end(), leases.ended.begin(), leases.ended.end());
    }

    /// The next batch, unless one is on its way. Nobody waits for leases: alone they make one only when `leases_too`.
    std::shared_ptr<const CommitBatch> begin(bool leases_too) {
        const bool leases = leases_too && !(next_.leases.given.empty() && next_.leases.ended.empty());
        if (on_its_way_ || (next_.results.empty() && !leases)) return nullptr;
        on_its_way_ = true;
        return std::make_shared<const CommitBatch>(std::exchange(next_, {}));
    }
    /// The leases of a batch that was not committed go with the next one; its results are added anew.
    void end(const CommitBatch& batch, bool committed) {
        on_its_way_ = false;
        if (!committed) add(batch.leases);
    }

private:
    CommitBatch next_;
    bool on_its_way_ = false;
};

}  // namespace lumenfarm
