#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

/// Whether the threads of a daemon still answer.
namespace lumenfarm {

/// A thread that serves.
struct ServingThread {
    using Answer = std::function<void()>;

    std::string name;                 ///< for people: "the disk"
    std::function<void(Answer)> ask;  ///< lets the thread call it in its turn; returns at once
    /// While it uses CPU time it need not answer for so long. 0: it has no work that takes long.
    double busy_seconds_max = 0;
};

/// A thread is alive when it has answered, or computes: to prepare a large scene takes minutes and is no reason to end
/// a daemon, nor is a slow disk, which costs its thread a little CPU time with every block. A call that hangs and a
/// lock that nobody opens cost none. An endless loop is found after busy_seconds_max.
class Pulse {
public:
    explicit Pulse(std::vector<ServingThread> threads);

    /// Nothing when every thread was alive since the last time that all of them were; they are then asked anew.
    /// Otherwise the name of one that was not. The threads must outlive this, or at least their `ask`.
    std::optional<std::string> silent(double now_s);

private:
    struct Mark;
    struct Watched {
        ServingThread thread;
        std::shared_ptr<Mark> mark;
        double asked_s = 0;
        double cpu_s = 0;  ///< when all were alive
    };
    static bool alive(const Watched& watched, double now_s);
    static void ask(Watched& watched, double now_s);

    std::vector<Watched> watched_;
};

}  // namespace lumenfarm
