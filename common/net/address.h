#pragma once

#include "common/support/result.h"

#include <boost/asio/ip/tcp.hpp>

#include <cstdint>
#include <string>

namespace lumenfarm::net {

/// HOST:PORT as people write it; [ADDRESS]:PORT for IPv6.
struct HostPort {
    std::string host;
    std::uint16_t port = 0;

    /// Errors: bad_input names the text and what is wrong with it. Port 0 is allowed: the system chooses.
    static Result<HostPort> parse(const std::string& text);
    std::string text() const;
    bool operator==(const HostPort&) const = default;
};

bool is_loopback(const boost::asio::ip::address& address);

std::string text_of(const boost::asio::ip::tcp::endpoint& endpoint);

}  // namespace lumenfarm::net
