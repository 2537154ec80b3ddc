#include "common/net/connector.h"

#include "common/support/limits.h"

#include <boost/asio/connect.hpp>
#include <boost/asio/steady_timer.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

namespace lumenfarm::net {

namespace asio = boost::asio;
using asio::ip::tcp;

struct Connector::Attempt : std::enable_shared_from_this<Attempt> {
    using ErrorCode = boost::system::error_code;

    Attempt(asio::io_context& io, HostPort where_, OnDone callback)
        : where(std::move(where_)), resolver(io), socket(io), timer(io), on_done(std::move(callback)) {}

    void start(double timeout_seconds) {
        timer.expires_after(
            std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(timeout_seconds)));
        timer.async_wait([self = shared_from_this()](const ErrorCode& error) {
            if (!error) self->fail("no answer in time");
        });
        resolver.async_resolve(
            where.host, std::to_string(where.port), tcp::resolver::numeric_service,
            [self = shared_from_this()](const ErrorCode& error, const tcp::resolver::results_type& found) {
                if (error) return self->fail("the name is not known");
                self->connect(found);
            });
    }
    void connect(const tcp::resolver::results_type& found) {
        if (!on_done) return;
        asio::async_connect(socket, found, [self = shared_from_this()](const ErrorCode& error, const tcp::endpoint&) {
            if (error) return self->fail(error.message());
            self->done(std::move(self->socket));
        });
    }
    void fail(const std::string& why) { done(failed("cannot connect to " + where.text() + ": " + why)); }
    void done(Result<tcp::socket> result) {
        if (!on_done) return;
        const auto callback = std::exchange(on_done, nullptr);
        stop();
        callback(std::move(result));
    }
    void stop() {
        on_done = nullptr;
        ErrorCode ignored;
        timer.cancel();
        resolver.cancel();
        if (socket.is_open()) socket.close(ignored);
    }

    HostPort where;
    tcp::resolver resolver;
    tcp::socket socket;
    asio::steady_timer timer;
    OnDone on_done;
};

Connector::Connector(asio::io_context& io, HostPort where, double timeout_seconds, OnDone on_done)
    : attempt_(std::make_shared<Attempt>(io, std::move(where), std::move(on_done))) {
    attempt_->start(timeout_seconds);
}

Connector::~Connector() { attempt_->stop(); }

double reconnect_delay_seconds(unsigned attempt, double uniform) {
    const double grown = limits::reconnect_seconds_min * std::exp2(std::min(attempt, 16u) + 1.0);
    const double most = std::min(limits::reconnect_seconds_max, grown);
    return limits::reconnect_seconds_min + uniform * (most - limits::reconnect_seconds_min);
}

}  // namespace lumenfarm::net
