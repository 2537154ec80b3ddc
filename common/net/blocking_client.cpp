#include "common/net/blocking_client.h"

#include "common/net/connection.h"
#include "common/net/connector.h"

#include <chrono>
#include <optional>
#include <random>

namespace lumenfarm::net {
namespace {

using Clock = std::chrono::steady_clock;

Clock::time_point from_now(double seconds) {
    return Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

std::uint64_t random_instance() {
    std::random_device device;
    return std::uint64_t{device()} << 32 | device();
}

Error error_of(const wire::Refusal& refusal) {
    const bool users =
        refusal.reason == wire::RefusalReason::bad_request || refusal.reason == wire::RefusalReason::no_such_job;
    return users ? bad_input(refusal.sentence) : failed(refusal.sentence);
}

Error error_of(const Closed& closed) {
    if (closed.goodbye && !closed.goodbye->text.empty())
        return failed("the master ended the session: " + closed.goodbye->text);
    return failed("the connection to the master ended: " + closed.sentence);
}

}  // namespace

struct BlockingClient::Session : ConnectionHandler {
    boost::asio::io_context io;
    std::shared_ptr<Connection> connection;
    std::uint64_t last_request = 0;
    std::optional<wire::Envelope> reply;
    std::optional<Closed> closed;

    void on_message(Connection&, wire::Envelope envelope) override {
        const bool answers = envelope.request_id == last_request;
        const bool beat = std::holds_alternative<wire::Heartbeat>(envelope.message) ||
                          std::holds_alternative<wire::HeartbeatReply>(envelope.message);
        if (answers && !beat) reply = std::move(envelope);
    }
    void on_close(Connection&, const Closed& how) override { closed = how; }

    /// Runs the io_context until `done`, the connection ended or the time is over.
    template <class Done>
    void run_until(Clock::time_point deadline, Done done) {
        io.restart();
        while (!done() && !closed && io.run_one_until(deadline) > 0) {
        }
    }
};

BlockingClient::BlockingClient(std::unique_ptr<Session> session) : session_(std::move(session)) {}
BlockingClient::BlockingClient(BlockingClient&&) noexcept = default;
BlockingClient& BlockingClient::operator=(BlockingClient&&) noexcept = default;

BlockingClient::~BlockingClient() {
    if (!session_ || !session_->connection) return;
    session_->connection->finish(wire::Goodbye(wire::GoodbyeReason::done));
    session_->run_until(from_now(limits::goodbye_seconds), [] { return false; });
    session_->connection->detach();
    session_->io.restart();
    session_->io.poll();
}

Result<BlockingClient> BlockingClient::connect(const HostPort& master, const std::string& name,
                                               double timeout_seconds) {
    auto session = std::make_unique<Session>();
    const auto deadline = from_now(timeout_seconds);
    std::optional<Result<boost::asio::ip::tcp::socket>> connected;
    Connector connector(session->io, master, timeout_seconds,
                        [&](auto result) { connected.emplace(std::move(result)); });
    session->run_until(deadline + std::chrono::seconds(1), [&] { return connected.has_value(); });
    if (!connected) return failed("cannot connect to " + master.text() + ": no answer in time");
    if (!*connected) return connected->error();
    session->connection = Connection::make(std::move(**connected), Connection::greeted(), *session);
    session->connection->start();
    session->connection->send(wire::Hello(wire::Role::submitter, name, random_instance()));
    session->run_until(deadline, [&] { return session->reply.has_value(); });
    if (session->closed) return error_of(*session->closed);
    const auto* welcome = session->reply ? std::get_if<wire::Welcome>(&session->reply->message) : nullptr;
    if (!welcome) return failed(master.text() + " does not answer like a master");
    session->connection->open_session(wire::from_master, {welcome->protocol, welcome->compress},
                                      welcome->heartbeat_seconds, welcome->dead_seconds);
    return BlockingClient(std::move(session));
}

Result<wire::Message> BlockingClient::ask(const wire::Message& request, double timeout_seconds) {
    auto& session = *session_;
    session.reply.reset();
    session.connection->send(request, ++session.last_request);
    session.run_until(from_now(timeout_seconds), [&] { return session.reply.has_value(); });
    if (!session.reply && session.closed) return error_of(*session.closed);
    if (!session.reply) return failed("the master did not answer in time");
    if (const auto* refusal = std::get_if<wire::Refusal>(&session.reply->message)) return error_of(*refusal);
    return std::move(session.reply->message);
}

Result<void> BlockingClient::tell(const wire::Message& message, double timeout_seconds) {
    auto& session = *session_;
    session.connection->send(message);
    session.run_until(from_now(timeout_seconds), [&] { return !session.connection->congested(); });
    if (session.closed) return error_of(*session.closed);
    if (session.connection->congested()) return failed("the master does not take the data in time");
    return {};
}

Result<void> BlockingClient::idle(double seconds) {
    session_->run_until(from_now(seconds), [] { return false; });
    if (session_->closed) return error_of(*session_->closed);
    return {};
}

Error BlockingClient::unexpected(const wire::Message& reply) {
    return failed("the master answered with " + std::string(wire::name_of(reply)) + ", which was not asked for");
}

}  // namespace lumenfarm::net
