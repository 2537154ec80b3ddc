#pragma once

#include "worker/trace_slot.h"

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

namespace lumenfarm::worker {

/// A TraceSlot with a thread of its own. Each command is answered by one report, from that thread.
class SlotThread {
public:
    using OnReport = std::function<void(SlotReport)>;

    SlotThread(bool idle_priority, OnReport on_report);
    ~SlotThread();  ///< after the slice at hand

    // REQUIRES of the three: the slot's last command has been answered.
    void start(SetWork work);
    void resume();
    void tell(SlotAsk ask);
    /// Heard after the slice at hand; dropped when the slot has just stopped.
    void interrupt(SlotAsk ask);
    /// The thread calls `answer` after the slice at hand, or at once when it has none. Replaces an earlier one.
    void ask(std::function<void()> answer);

private:
    struct Command {
        std::optional<SetWork> work;
        SlotAsk ask = SlotAsk::nothing;
    };
    void give(Command command);
    void run(bool idle_priority);
    SlotReport obey(Command command);
    /// REQUIRES: mutex_ is locked.
    void answer();

    OnReport on_report_;
    TraceSlot slot_;
    std::mutex mutex_;
    std::condition_variable given_;
    std::optional<Command> command_;
    SlotAsk interrupt_ = SlotAsk::nothing;
    std::function<void()> answer_;  ///< that somebody waits for
    bool busy_ = false;
    bool ending_ = false;
    std::thread thread_;
};

}  // namespace lumenfarm::worker
