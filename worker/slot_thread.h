#pragma once

#include "worker/slot.h"

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

namespace lumenfarm::worker {

/// A TraceSlot with a thread of its own, which reports.
class SlotThread : public Slot {
public:
    SlotThread(bool idle_priority, OnReport on_report);
    ~SlotThread() override;  ///< after the slice at hand

    void start(SetWork work) override;
    void resume() override;
    void tell(SlotAsk ask) override;
    void interrupt(SlotAsk ask) override;
    void ask(std::function<void()> answer) override;

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
