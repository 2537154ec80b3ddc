#pragma once

#include "tests/scratch/folder.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// The real programs, started as a user would, under a watchdog.
namespace lumenfarm::testing {

using Clock = std::chrono::steady_clock;
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
inline constexpr std::chrono::seconds watchdog{600};  // a picture takes minutes
#else
inline constexpr std::chrono::seconds watchdog{90};
#endif

inline std::string last_words(const std::string& said) {
    return said.substr(said.size() - std::min<std::size_t>(said.size(), 3'000));
}

inline std::string program(const std::string& name) { return std::string(LUMENFARM_BINARY_DIR) + "/bin/" + name; }

class Process {
public:
    /// The environment is the test's without the settings of a developer's own farm, and `environment` ("NAME=value").
    explicit Process(std::vector<std::string> command, std::vector<std::string> environment = {}) {
        std::array<int, 2> out{}, err{};
        if (::pipe2(out.data(), O_CLOEXEC) != 0 || ::pipe2(err.data(), O_CLOEXEC) != 0) std::abort();
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
        posix_spawn_file_actions_adddup2(&actions, out[1], STDOUT_FILENO);
        posix_spawn_file_actions_adddup2(&actions, err[1], STDERR_FILENO);
        for (char** entry = environ; *entry; ++entry)
            if (!std::string_view(*entry).starts_with("LUMENFARM_")) environment.emplace_back(*entry);
        if (::posix_spawn(&pid_, command.front().c_str(), &actions, nullptr, pointers(command).data(),
                          pointers(environment).data()) != 0)
            pid_ = -1;
        posix_spawn_file_actions_destroy(&actions);
        ::close(out[1]);
        ::close(err[1]);
        pipes_ = {{{out[0], {}}, {err[0], {}}}};
    }
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;
    ~Process() {
        if (!status_ && pid_ > 0) {
            read_now();
            if (before_kill) before_kill(err());
            ::kill(pid_, SIGKILL);
            ::waitpid(pid_, nullptr, 0);
        }
        for (auto& pipe : pipes_)
            if (pipe.fd >= 0) ::close(pipe.fd);
    }

    /// Gets what one that still runs has said on stderr, before it is killed.
    std::function<void(const std::string& said)> before_kill;

    pid_t id() const { return pid_; }
    /// What has come so far.
    const std::string& out() const { return pipes_[0].text; }
    const std::string& err() const { return pipes_[1].text; }
    void send(int signal) const {
        if (pid_ > 0 && !status_) ::kill(pid_, signal);
    }

    /// Reads what comes until `enough`, the end of both streams or the watchdog. True when enough.
    bool read_until(const std::function<bool()>& enough) {
        const auto deadline = Clock::now() + watchdog;
        while (!enough()) {
            std::array<pollfd, 2> polled{{{pipes_[0].fd, POLLIN, 0}, {pipes_[1].fd, POLLIN, 0}}};
            const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
            if (pipes_[0].fd < 0 && pipes_[1].fd < 0) return false;
            if (left <= 0 || ::poll(polled.data(), polled.size(), static_cast<int>(left)) <= 0) return false;
            for (std::size_t i = 0; i < polled.size(); ++i)
                if (polled[i].revents != 0) take(pipes_[i]);
        }
        return true;
    }

    /// Reads what is there. A program that talks much stands still when nobody reads.
    void read_now() {
        for (auto& pipe : pipes_)
            for (pollfd polled{pipe.fd, POLLIN, 0}; pipe.fd >= 0 && ::poll(&polled, 1, 0) > 0;) take(pipe);
    }

    /// Exit status; -signal when a signal ended it; nothing when the watchdog did (then it is killed).
    std::optional<int> wait() {
        if (pid_ <= 0) return 127;
        const bool closed = !read_until([this] { return pipes_[0].fd < 0 && pipes_[1].fd < 0; }) && pipes_[0].fd >= 0;
        if (closed) ::kill(pid_, SIGKILL);
        int status = 0;
        if (!status_ && ::waitpid(pid_, &status, 0) == pid_) status_ = status;
        if (closed) return {};
        return WIFEXITED(*status_) ? WEXITSTATUS(*status_) : -WTERMSIG(*status_);
    }

private:
    struct Pipe {
        int fd = -1;
        std::string text;
    };
    static std::vector<char*> pointers(std::vector<std::string>& texts) {
        std::vector<char*> all;
        for (auto& text : texts) all.push_back(text.data());
        all.push_back(nullptr);
        return all;
    }
    static void take(Pipe& pipe) {
        std::array<char, 4096> buffer{};
        const auto got = ::read(pipe.fd, buffer.data(), buffer.size());
        if (got > 0) {
            pipe.text.append(buffer.data(), static_cast<std::size_t>(got));
            return;
        }
        ::close(pipe.fd);
        pipe.fd = -1;
    }

    pid_t pid_ = -1;
    std::optional<int> status_;
    std::array<Pipe, 2> pipes_{};
};

/// Whether the command, found in the path, ends with 0.
inline bool succeeds(std::vector<std::string> command) {
    command.insert(command.begin(), "/usr/bin/env");
    return Process(std::move(command)).wait() == 0;
}

/// The rest of the first line that begins with `begin`.
inline std::string line_after(const std::string& text, const std::string& begin) {
    std::size_t at = 0;
    while (at < text.size()) {
        const auto end = std::min(text.find('\n', at), text.size());
        const std::string line = text.substr(at, end - at);
        if (line.starts_with(begin)) return line.substr(begin.size());
        at = end + 1;
    }
    return {};
}

}  // namespace lumenfarm::testing
