#pragma once

#include "common/service/pulse.h"
#include "common/service/service_manager.h"

#include <csignal>
#include <functional>
#include <optional>
#include <string>
#include <vector>

/// What a daemon's main thread does while the others work.
namespace lumenfarm {

/// SIGINT and SIGTERM, which no thread handles and Attendant takes. To be made before any thread starts: they all
/// inherit the mask.
class EndSignals {
public:
    EndSignals();
    /// The next one, if it comes within `seconds`.
    std::optional<int> wait(double seconds) const;

private:
    sigset_t signals_{};
};

/// Waits for signals, tells systemd how it stands, and lets it know that every thread answers.
class Attendant {
public:
    /// `line`: of now, for `systemctl status`. Both must not wait for a thread of the daemon's.
    Attendant(const EndSignals& signals, std::vector<ServingThread> threads, std::function<std::string()> line);

    void ready();
    void stopping() { manager_.stopping(); }
    /// A look at everything; a signal, if one came within a tenth of a second. To be called again and again.
    std::optional<int> look();

private:
    void ping(double now_s);
    void say(double now_s);

    const EndSignals& signals_;
    ServiceManager manager_;
    Pulse pulse_;
    std::function<std::string()> line_;
    std::optional<double> watchdog_seconds_;
    double pinged_s_ = 0;
    double said_s_ = 0;
    std::string said_;
    std::optional<std::string> silent_;  ///< who did not answer at the last look
};

}  // namespace lumenfarm
