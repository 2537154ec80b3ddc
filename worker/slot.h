#pragma once

#include "worker/trace_slot.h"

#include <functional>

namespace lumenfarm::worker {

/// Where a worker's sets are traced, one at a time. Each command is answered by one report, from whatever thread.
class Slot {
public:
    virtual ~Slot() = default;

    // REQUIRES of the three: the slot's last command has been answered.
    virtual void start(SetWork work) = 0;
    virtual void resume() = 0;
    virtual void tell(SlotAsk ask) = 0;
    /// Heard after the slice at hand; dropped when the slot has just stopped.
    virtual void interrupt(SlotAsk ask) = 0;
    /// Calls `answer` after the slice at hand, or at once when there is none. Replaces an earlier one.
    virtual void ask(std::function<void()> answer) = 0;
};

using OnReport = std::function<void(SlotReport)>;

}  // namespace lumenfarm::worker
