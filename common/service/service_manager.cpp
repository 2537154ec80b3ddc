#include "common/service/service_manager.h"

#include <systemd/sd-daemon.h>

#include <algorithm>
#include <cstdint>

namespace lumenfarm {

void ServiceManager::ready() const { sd_notify(0, "READY=1"); }
void ServiceManager::stopping() const { sd_notify(0, "STOPPING=1"); }
void ServiceManager::alive() const { sd_notify(0, "WATCHDOG=1"); }

void ServiceManager::say(const std::string& line) const {
    std::string assignment = "STATUS=" + line;
    // a line break would begin another assignment
    std::replace(assignment.begin(), assignment.end(), '\n', ' ');
    sd_notify(0, assignment.c_str());
}

std::optional<double> ServiceManager::watchdog_seconds() const {
    std::uint64_t microseconds = 0;
    if (sd_watchdog_enabled(0, &microseconds) <= 0) return std::nullopt;
    return 1e-6 * static_cast<double>(microseconds);
}

}  // namespace lumenfarm
