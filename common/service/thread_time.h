#pragma once

#include <time.h>

namespace lumenfarm {

/// Processor time that this thread has taken [s].
inline double thread_cpu_seconds() {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace lumenfarm
