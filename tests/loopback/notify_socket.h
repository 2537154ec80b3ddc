#pragma once

#include "tests/loopback/process.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace lumenfarm::testing {

/// systemd's end of what a daemon tells it (sd_notify).
class NotifySocket {
public:
    explicit NotifySocket(const std::string& path) : path_(path), fd_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
        if (fd_ < 0 || ::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) std::abort();
    }
    ~NotifySocket() { close(); }
    NotifySocket(const NotifySocket&) = delete;
    NotifySocket& operator=(const NotifySocket&) = delete;

    /// What a daemon finds in its environment. With a watchdog that wants a ping every tenth of a second.
    std::vector<std::string> environment() const { return {"NOTIFY_SOCKET=" + path_, "WATCHDOG_USEC=400000"}; }

    const std::vector<std::string>& heard() const { return heard_; }
    std::ptrdiff_t count(const std::string& message) const { return std::ranges::count(heard_, message); }
    bool has(const std::string& message) const { return count(message) > 0; }
    /// True when a line for people holds the text.
    bool said(const std::string& text) const {
        return std::ranges::any_of(heard_, [&](const std::string& message) {
            return message.starts_with("STATUS=") && message.find(text) != std::string::npos;
        });
    }
    void forget() { heard_.clear(); }
    /// Nobody listens any more. A daemon waits for a socket that is open, full and not read.
    void close() {
        if (fd_ >= 0) ::close(std::exchange(fd_, -1));
    }

    /// Listens until `enough` or the watchdog of the tests. True when enough.
    bool listen_until(const std::function<bool()>& enough) {
        const auto deadline = Clock::now() + watchdog;
        while (!enough()) {
            const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
            if (left <= 0 || !take(static_cast<int>(left))) return false;
        }
        return true;
    }
    /// Takes what has come so far.
    void listen_now() {
        while (take(0)) continue;
    }

private:
    bool take(int milliseconds) {
        pollfd polled{fd_, POLLIN, 0};
        if (::poll(&polled, 1, milliseconds) <= 0) return false;
        std::array<char, 4096> buffer{};
        const auto got = ::recv(fd_, buffer.data(), buffer.size(), 0);
        if (got < 0) return false;
        heard_.emplace_back(buffer.data(), static_cast<std::size_t>(got));
        return true;
    }

    std::string path_;
    int fd_;
    std::vector<std::string> heard_;
};

}  // namespace lumenfarm::testing
