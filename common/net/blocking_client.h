#pragma once

#include "common/net/address.h"
#include "common/support/result.h"
#include "proto/messages.h"

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

namespace lumenfarm::net {

/// A submitter's session for programs that ask and wait: its own io_context, run only inside the calls. Between calls
/// no heartbeat leaves, so ask again within limits::dead_seconds or call idle(), or the master closes.
class BlockingClient {
public:
    /// Connects and says Hello. Errors: failed: nobody there, no answer in time, or refused; the sentence says which.
    static Result<BlockingClient> connect(const HostPort& master, const std::string& name,
                                          double timeout_seconds = limits::connect_seconds);
    BlockingClient(BlockingClient&&) noexcept;
    BlockingClient& operator=(BlockingClient&&) noexcept;
    ~BlockingClient();  ///< says Goodbye

    /// Sends a request and waits for its reply. Errors: bad_input when refused with bad_request or no_such_job, failed
    /// otherwise (refusal, lost connection, no answer in time), with the master's sentence.
    Result<wire::Message> ask(const wire::Message& request, double timeout_seconds = limits::reply_seconds);

    /// The same, for one type of reply. Errors: failed when another type comes.
    template <class Reply>
    Result<Reply> ask_for(const wire::Message& request, double timeout_seconds = limits::reply_seconds) {
        auto reply = ask(request, timeout_seconds);
        if (!reply) return reply.error();
        if (auto* wanted = std::get_if<Reply>(&*reply)) return std::move(*wanted);
        return unexpected(*reply);
    }

    /// Sends a message that has no reply; waits while the outbox is full. Errors: failed.
    Result<void> tell(const wire::Message& message, double timeout_seconds = limits::reply_seconds);

    /// Waits and keeps the session alive. Errors: failed when the connection was lost.
    Result<void> idle(double seconds);

private:
    struct Session;
    explicit BlockingClient(std::unique_ptr<Session> session);
    static Error unexpected(const wire::Message& reply);
    std::unique_ptr<Session> session_;
};

}  // namespace lumenfarm::net
