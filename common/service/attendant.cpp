#include "common/service/attendant.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <cmath>
#include <utility>

namespace lumenfarm {

namespace {

constexpr double look_seconds = 0.1;
constexpr double line_seconds = 1;         ///< at least, between two lines that are told
constexpr double pings_in_a_watchdog = 4;  ///< so that one that comes late does no harm

double now_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

}  // namespace

EndSignals::EndSignals() {
    sigemptyset(&signals_);
    sigaddset(&signals_, SIGINT);
    sigaddset(&signals_, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
}

std::optional<int> EndSignals::wait(double seconds) const {
    const double whole = std::floor(seconds);
    const timespec limit{static_cast<time_t>(whole), static_cast<long>(1e9 * (seconds - whole))};
    const int signal = sigtimedwait(&signals_, nullptr, &limit);
    return signal > 0 ? std::optional(signal) : std::nullopt;
}

Attendant::Attendant(const EndSignals& signals, std::vector<ServingThread> threads, std::function<std::string()> line)
    : signals_(signals),
      pulse_(std::move(threads)),
      line_(std::move(line)),
      watchdog_seconds_(manager_.watchdog_seconds()) {}

void Attendant::ready() {
    manager_.ready();
    pinged_s_ = now_s();
    pulse_.silent(pinged_s_);
}

std::optional<int> Attendant::look() {
    const auto signal = signals_.wait(look_seconds);
    const double time_s = now_s();
    ping(time_s);
    say(time_s);
    return signal;
}

void Attendant::ping(double now_s) {
    if (!watchdog_seconds_ || now_s < pinged_s_ + *watchdog_seconds_ / pings_in_a_watchdog) return;
    auto silent = pulse_.silent(now_s);
    if (!silent) {
        if (silent_) spdlog::info("{} answers again", *silent_);
        manager_.alive();
        pinged_s_ = now_s;
    } else if (!silent_) {
        spdlog::warn("{} does not answer; without an answer within {:.3g} s systemd starts this daemon anew", *silent,
                     pinged_s_ + *watchdog_seconds_ - now_s);
    }
    silent_ = std::move(silent);
}

void Attendant::say(double now_s) {
    std::string line = silent_ ? *silent_ + " does not answer" : line_();
    if (line == said_ || now_s < said_s_ + (silent_ ? 0 : line_seconds)) return;
    manager_.say(line);
    said_ = std::move(line);
    said_s_ = now_s;
}

}  // namespace lumenfarm
