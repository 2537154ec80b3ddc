#pragma once

#include "common/support/result.h"

#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

/// Where the command talks: results to stdout; progress, warnings and errors to stderr.
namespace lumenfarm {

class Console {
public:
    Console();

    /// A line, or a document that ends with a line break, of results.
    void result(const std::string& text);
    /// One line for the person at the terminal.
    void note(const std::string& line);
    void warnings(const std::vector<std::string>& sentences);
    void error(const Error& error);

    /// What goes on. On a terminal one line that is written over, else a plain line every now and then.
    void progress(const std::string& line);
    /// Ends a line that was being written over, with this as its last text.
    void end_progress(const std::string& line);

    /// Errors: failed when results could not be written (a full disk behind `>`).
    Result<void> finish();

private:
    void clear_line();

    bool terminal_;      ///< stderr is one
    bool open_ = false;  ///< a progress line stands on the terminal
    std::chrono::steady_clock::time_point next_{};
    std::string last_;
};

}  // namespace lumenfarm
