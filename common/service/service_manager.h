#pragma once

#include <optional>
#include <string>

/// What systemd is told of a daemon (sd_notify). Without systemd nobody listens, and nothing happens.
namespace lumenfarm {

class ServiceManager {
public:
    void ready() const;     ///< it serves
    void stopping() const;  ///< it has begun to end
    /// One line for `systemctl status`.
    void say(const std::string& line) const;
    /// Everything answers. To be said more often than every watchdog_seconds(), or the daemon is started anew.
    void alive() const;
    /// Nothing: nobody waits for alive().
    std::optional<double> watchdog_seconds() const;
};

}  // namespace lumenfarm
