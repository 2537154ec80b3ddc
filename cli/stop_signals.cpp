#include "cli/stop_signals.h"

#include "common/support/result.h"

#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <string_view>
#include <utility>

namespace lumenfarm {
namespace {

/// The two signals, and SIGUSR1, with which the destructor wakes the thread.
sigset_t watched() {
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGINT);
    sigaddset(&set, SIGTERM);
    sigaddset(&set, SIGUSR1);
    return set;
}

}  // namespace

StopSignals::StopSignals(std::function<void()> sweep) : sweep_(std::move(sweep)) {
    const sigset_t set = watched();
    pthread_sigmask(SIG_BLOCK, &set, nullptr);
    thread_ = std::thread([this] { wait_for_signals(); });
}

StopSignals::~StopSignals() {
    pthread_kill(thread_.native_handle(), SIGUSR1);
    thread_.join();
}

void StopSignals::wait_for_signals() {
    const sigset_t set = watched();
    for (int signal = 0; sigwait(&set, &signal) == 0 && signal != SIGUSR1;) {
        if (keeping_ && !asked_.exchange(true)) continue;
        sweep_();
        constexpr std::string_view last_words = "\nlumenfarm: stopped at once\n";
        [[maybe_unused]] const auto written = ::write(STDERR_FILENO, last_words.data(), last_words.size());
        ::_exit(exit_code(interrupted({})));
    }
}

}  // namespace lumenfarm
