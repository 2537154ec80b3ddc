#pragma once

#include "common/net/address.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>

#include <functional>
#include <memory>

namespace lumenfarm::net {

/// One attempt to connect: looks the name up, tries its addresses in turn.
class Connector {
public:
    using OnDone = std::function<void(Result<boost::asio::ip::tcp::socket>)>;

    /// Calls `on_done` once from the io_context, unless this is destroyed before. Errors: failed, with host, port and
    /// reason, at the latest after `timeout_seconds`.
    Connector(boost::asio::io_context& io, HostPort where, double timeout_seconds, OnDone on_done);
    ~Connector();
    Connector(const Connector&) = delete;
    Connector& operator=(const Connector&) = delete;

private:
    struct Attempt;
    std::shared_ptr<Attempt> attempt_;
};

/// Seconds to wait before attempt number `attempt` (0 is the first after a loss): full jitter, uniform between
/// limits::reconnect_seconds_min and min(limits::reconnect_seconds_max, reconnect_seconds_min * 2^(attempt + 1)).
/// `uniform` is in [0, 1). A farm of workers that lost their master does not come back all at once.
/// [Brooker, Exponential backoff and jitter, 2015]
double reconnect_delay_seconds(unsigned attempt, double uniform);

}  // namespace lumenfarm::net
