#include "cli/console.h"

#include <unistd.h>

namespace lumenfarm {
namespace {

constexpr std::chrono::milliseconds terminal_interval{200};
constexpr std::chrono::milliseconds plain_interval{5000};

/// Sentences stay on one line whatever text of a user's or a library's stands in them.
std::string one_line(std::string text) {
    while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
    for (char& c : text)
        if (static_cast<unsigned char>(c) < ' ') c = ' ';
    return text;
}

}  // namespace

Console::Console() : terminal_(::isatty(STDERR_FILENO) == 1) {}

void Console::result(const std::string& text) {
    clear_line();
    std::fputs(text.c_str(), stdout);
    if (text.empty() || text.back() != '\n') std::fputc('\n', stdout);
}

void Console::note(const std::string& line) {
    clear_line();
    std::fprintf(stderr, "%s\n", one_line(line).c_str());
}

void Console::warnings(const std::vector<std::string>& sentences) {
    for (const auto& sentence : sentences) note("lumenfarm: warning: " + sentence);
}

void Console::error(const Error& error) { note("lumenfarm: " + error.sentence); }

void Console::progress(const std::string& line) {
    const auto now = std::chrono::steady_clock::now();
    if (now < next_ || line == last_) return;
    next_ = now + (terminal_ ? terminal_interval : plain_interval);
    last_ = line;
    open_ = terminal_;
    std::fprintf(stderr, terminal_ ? "\r\x1b[K%s" : "%s\n", line.c_str());
}

void Console::end_progress(const std::string& line) {
    if (line != last_ || open_) note(line);
    last_.clear();
    next_ = {};
}

Result<void> Console::finish() {
    clear_line();
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
        return failed("the results could not be written to the standard output");
    return {};
}

void Console::clear_line() {
    if (open_) std::fputs("\r\x1b[K", stderr);
    open_ = false;
}

}  // namespace lumenfarm
