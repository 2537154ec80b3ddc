#pragma once

#include "proto/messages.h"

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

/// Leases that go back to the master. One that results still claim goes back after them, so that they find it current.
namespace lumenfarm::worker {

class LeaseReturns {
public:
    using Claimed = std::function<bool(std::uint64_t lease)>;

    void add(wire::ReturnReason reason, std::uint64_t lease, std::uint32_t epoch) {
        waiting_[reason].emplace_back(lease, epoch);
    }
    /// Takes out what may go now.
    std::vector<wire::ReturnLeases> take(const Claimed& claimed);
    /// A new session begins: what is not stated in it is taken back without a word.
    void keep_only(const Claimed& claimed);
    bool empty() const { return waiting_.empty(); }

private:
    std::map<wire::ReturnReason, std::vector<wire::LeaseRef>> waiting_;
};

}  // namespace lumenfarm::worker
