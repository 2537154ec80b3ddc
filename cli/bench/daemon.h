#pragma once

#include "common/support/result.h"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace lumenfarm {

/// A daemon of this installation as a process of its own, whatever its configuration file and the environment say. It
/// ends with this program. Its log goes to a file.
class Daemon {
public:
    /// `program`: lumenfarm-master, lumenfarm-worker or lumenfarm, as it lies beside this program. Errors: failed.
    static Result<std::unique_ptr<Daemon>> start(const std::string& program, std::vector<std::string> arguments,
                                                 const std::filesystem::path& log);
    ~Daemon();  ///< stop()
    Daemon(const Daemon&) = delete;
    Daemon& operator=(const Daemon&) = delete;

    /// What its log has between `begin` and the next `end`, as soon as it is there. Errors: failed (it ended before, or
    /// took longer than limits::connect_seconds), with its last line.
    Result<std::string> wait_for(const std::string& begin, const std::string& end) const;
    /// Errors: failed, with its last line.
    Result<void> check_running() const;
    /// Processor time that it has taken so far [s], of all its threads.
    double cpu_seconds() const;
    /// SIGTERM, and waits for its end.
    void stop();
    /// It does nothing any more, and its connections stay open, until stop().
    void suspend();

private:
    struct Process;
    Daemon(std::unique_ptr<Process> process, std::string program, std::filesystem::path log);
    Error ended() const;

    std::unique_ptr<Process> process_;
    std::string program_;
    std::filesystem::path log_;
};

}  // namespace lumenfarm
