#include "common/service/pulse.h"

#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <ctime>
#include <utility>

namespace lumenfarm {

/// What a thread leaves when it answers.
struct Pulse::Mark {
    std::atomic<bool> answered = true;
    std::atomic<bool> known = false;  ///< clock is set
    std::atomic<clockid_t> clock{};   ///< of the CPU time of the thread

    void set() {
        clockid_t own{};
        if (pthread_getcpuclockid(pthread_self(), &own) == 0) {
            clock = own;
            known = true;
        }
        answered = true;
    }
    double cpu_s() const {
        timespec time{};
        if (!known || clock_gettime(clock, &time) != 0) return 0;
        return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
    }
};

Pulse::Pulse(std::vector<ServingThread> threads) {
    for (ServingThread& thread : threads) watched_.push_back({std::move(thread), std::make_shared<Mark>()});
}

bool Pulse::alive(const Watched& watched, double now_s) {
    if (watched.mark->answered) return true;
    return now_s - watched.asked_s <= watched.thread.busy_seconds_max && watched.mark->cpu_s() > watched.cpu_s;
}

void Pulse::ask(Watched& watched, double now_s) {
    watched.cpu_s = watched.mark->cpu_s();
    if (!watched.mark->answered) return;
    watched.mark->answered = false;
    watched.asked_s = now_s;
    watched.thread.ask([mark = watched.mark] { mark->set(); });
}

std::optional<std::string> Pulse::silent(double now_s) {
    const auto dead =
        std::find_if(watched_.begin(), watched_.end(), [&](const Watched& watched) { return !alive(watched, now_s); });
    if (dead != watched_.end()) return dead->thread.name;
    for (Watched& watched : watched_) ask(watched, now_s);
    return std::nullopt;
}

}  // namespace lumenfarm
