#include "common/net/listener.h"

#include "common/support/limits.h"

#include <chrono>
#include <utility>

namespace lumenfarm::net {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

Error listen_error(const HostPort& where, const boost::system::error_code& error) {
    const auto start = "cannot listen on " + where.text() + ": ";
    if (error == asio::error::address_in_use) return failed(start + "the port is in use by another program");
    if (error == asio::error::access_denied) return failed(start + "this user may not use that port");
    return failed(start + error.message());
}

boost::system::error_code bind_and_listen(tcp::acceptor& acceptor, const tcp::endpoint& endpoint) {
    boost::system::error_code error;
    acceptor.open(endpoint.protocol(), error);
    if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor.bind(endpoint, error);
    if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
    return error;
}

}  // namespace

struct Listener::Shared : std::enable_shared_from_this<Shared> {
    Shared(asio::io_context& io, OnAccept accepted, OnFailure failed)
        : acceptor(io), retry(io), on_accept(std::move(accepted)), on_failure(std::move(failed)) {}

    void accept() {
        acceptor.async_accept([self = shared_from_this()](const boost::system::error_code& error, tcp::socket socket) {
            if (!self->acceptor.is_open()) return;
            if (error) return self->accept_later(error);
            self->failing = false;
            self->on_accept(std::move(socket));
            if (self->acceptor.is_open()) self->accept();
        });
    }
    /// Out of file descriptors or memory: the machine needs a moment, a tight loop would not help it.
    void accept_later(const boost::system::error_code& why) {
        if (!std::exchange(failing, true) && on_failure) on_failure(why.message());
        retry.expires_after(std::chrono::duration_cast<std::chrono::nanoseconds>(
            std::chrono::duration<double>(limits::accept_retry_seconds)));
        retry.async_wait([self = shared_from_this()](const boost::system::error_code& error) {
            if (!error && self->acceptor.is_open()) self->accept();
        });
    }
    void stop() {
        boost::system::error_code ignored;
        acceptor.close(ignored);
        retry.cancel();
        on_accept = nullptr;
        on_failure = nullptr;
    }

    tcp::acceptor acceptor;
    asio::steady_timer retry;
    OnAccept on_accept;
    OnFailure on_failure;
    bool failing = false;
    tcp::endpoint local;
};

Result<std::unique_ptr<Listener>> Listener::open(asio::io_context& io, const HostPort& where, OnAccept on_accept,
                                                 OnFailure on_failure) {
    boost::system::error_code error;
    tcp::resolver resolver(io);
    const auto found = resolver.resolve(where.host, std::to_string(where.port),
                                        tcp::resolver::passive | tcp::resolver::numeric_service, error);
    if (error || found.empty())
        return bad_input("cannot listen on " + where.text() + ": this machine knows no address of that name");
    auto shared = std::make_shared<Shared>(io, std::move(on_accept), std::move(on_failure));
    error = bind_and_listen(shared->acceptor, found.begin()->endpoint());
    if (error) return listen_error(where, error);
    shared->local = shared->acceptor.local_endpoint(error);
    if (error) return listen_error(where, error);
    shared->accept();
    return std::unique_ptr<Listener>(new Listener(std::move(shared)));
}

Listener::Listener(std::shared_ptr<Shared> shared) : shared_(std::move(shared)) {}
Listener::~Listener() { shared_->stop(); }

const tcp::endpoint& Listener::local() const { return shared_->local; }
bool Listener::on_loopback() const { return is_loopback(shared_->local.address()); }

}  // namespace lumenfarm::net
