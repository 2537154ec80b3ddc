#pragma once

#include <atomic>
#include <functional>
#include <thread>

namespace lumenfarm {

/// SIGINT and SIGTERM of a program that keeps what is done. A thread of its own waits for them, so that they work
/// whatever the others do. The program ends at once, with status 3, on the first signal while nothing can be kept, and
/// on the second otherwise.
class StopSignals {
public:
    /// `sweep` removes files that must not stay half-written; it runs just before the program ends at once.
    /// REQUIRES: made before any other thread, on the thread that starts them: they inherit that signals are blocked.
    explicit StopSignals(std::function<void()> sweep);
    ~StopSignals();
    StopSignals(const StopSignals&) = delete;
    StopSignals& operator=(const StopSignals&) = delete;

    /// From now on the first signal only makes asked() true.
    void keep_what_is_done() { keeping_ = true; }
    /// From now on a signal ends the program at once again.
    void end_at_once() { keeping_ = false; }
    bool asked() const { return asked_; }

private:
    void wait_for_signals();

    std::function<void()> sweep_;
    std::atomic<bool> keeping_ = false;
    std::atomic<bool> asked_ = false;
    std::thread thread_;
};

}  // namespace lumenfarm
