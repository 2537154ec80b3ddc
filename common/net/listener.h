#pragma once

#include "common/net/address.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>

#include <functional>
#include <memory>
#include <string>

namespace lumenfarm::net {

/// Accepts connections on one address until it is destroyed. Runs on the io_context's thread.
class Listener {
public:
    using OnAccept = std::function<void(boost::asio::ip::tcp::socket)>;
    using OnFailure = std::function<void(const std::string& why)>;

    /// Binds and listens; blocks while a host name is looked up. Errors: bad_input when the host has no address here,
    /// failed when the port is busy or may not be bound: the sentence names it.
    /// `on_failure`: nobody can be accepted for the moment (no descriptors, no memory); told once until it works again.
    static Result<std::unique_ptr<Listener>> open(boost::asio::io_context& io, const HostPort& where,
                                                  OnAccept on_accept, OnFailure on_failure = {});
    ~Listener();
    Listener(const Listener&) = delete;
    Listener& operator=(const Listener&) = delete;

    const boost::asio::ip::tcp::endpoint& local() const;  ///< with the port that the system chose
    bool on_loopback() const;

private:
    struct Shared;
    explicit Listener(std::shared_ptr<Shared> shared);
    std::shared_ptr<Shared> shared_;
};

}  // namespace lumenfarm::net
