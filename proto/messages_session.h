#pragma once

#include "common/support/limits.h"
#include "proto/archive.h"
#include "proto/message_type.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

/// Messages that open, keep and end a session. Every message has a constructor: g++ 12 destroys aggregate temporaries
/// twice inside co_await expressions.
namespace lumenfarm::wire {

enum class Role : std::uint8_t {
    worker,
    submitter,
    relay,  ///< a worker whose threads are those of the workers behind it
};
constexpr Role enum_last(Role) { return Role::relay; }
constexpr bool pulls_work(Role role) { return role != Role::submitter; }
std::string_view name_of(Role role);

/// worker, relay or submitter -> master, first message, within limits::hello_seconds. Its layout is the same in every
/// version.
struct Hello {
    static constexpr auto type = MessageType::hello;
    std::uint16_t protocol = protocol_newest;  ///< the newest version that the sender speaks
    Role role = Role::worker;
    std::string name;            ///< of the machine, at most limits::peer_name_bytes_max
    std::uint64_t instance = 0;  ///< random, of the process: the same after a reconnect
    std::uint32_t threads = 0;   ///< worker; a relay says in its Pulls how many there are
    std::uint64_t memory_bytes = 0;
    std::string isa;                ///< worker: Embree's, at most limits::isa_bytes_max
    std::uint64_t fingerprint = 0;  ///< worker: hash over a fixed small trace

    Hello() = default;
    Hello(Role role_, std::string name_, std::uint64_t instance_)
        : role(role_), name(std::move(name_)), instance(instance_) {}
    bool operator==(const Hello&) const = default;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, protocol, role, at_most(name, limits::peer_name_bytes_max), instance, threads, memory_bytes,
               at_most(isa, limits::isa_bytes_max), fingerprint);
    }
};

/// master -> worker or submitter, the answer to Hello. The session speaks `protocol` from here on.
struct Welcome {
    static constexpr auto type = MessageType::welcome;
    std::uint16_t protocol = protocol_newest;
    std::uint64_t session = 0;
    double heartbeat_seconds = limits::heartbeat_seconds;         ///< both sides send a Heartbeat this often
    double dead_seconds = limits::dead_seconds;                   ///< and close when nothing arrived for this long
    double reconnect_seconds = limits::reconnect_seconds;         ///< leases of a lost connection wait this long
    std::uint32_t results_in_flight = limits::results_in_flight;  ///< credit: results sent and not yet acknowledged
    bool compress = false;                                        ///< the worker compresses its results

    Welcome() = default;
    explicit Welcome(std::uint64_t session_) : session(session_) {}
    bool operator==(const Welcome&) const = default;
    bool valid() const {
        return results_in_flight > 0 && results_in_flight <= limits::results_in_flight_max && heartbeat_seconds > 0 &&
               dead_seconds > heartbeat_seconds && reconnect_seconds >= 0;
    }

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, protocol, session, heartbeat_seconds, dead_seconds, reconnect_seconds, results_in_flight, compress);
    }
};

enum class GoodbyeReason : std::uint8_t {
    done,                  ///< the sender has nothing more to do here
    shutting_down,         ///< the sender ends; try again later
    unsupported_protocol,  ///< no common version
    refused,               ///< this peer is not wanted; the text says why. Do not try again
    farm_full,             ///< limits::sessions_max is reached; try again later
    protocol_error,        ///< the peer broke the protocol; the text says how
    replaced,              ///< the same instance opened a newer session
};
constexpr GoodbyeReason enum_last(GoodbyeReason) { return GoodbyeReason::replaced; }
std::string_view name_of(GoodbyeReason reason);

/// either direction, the last message of a session. Its layout is the same in every version.
struct Goodbye {
    static constexpr auto type = MessageType::goodbye;
    GoodbyeReason reason = GoodbyeReason::done;
    std::string text;  ///< a sentence for people, at most limits::sentence_bytes_max

    Goodbye() = default;
    explicit Goodbye(GoodbyeReason reason_, std::string text_ = {}) : reason(reason_), text(std::move(text_)) {}
    bool operator==(const Goodbye&) const = default;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, reason, at_most(text, limits::sentence_bytes_max));
    }
};

/// either direction, every heartbeat_seconds. Answered at once by a HeartbeatReply with the same sequence.
struct Heartbeat {
    static constexpr auto type = MessageType::heartbeat;
    std::uint64_t sequence = 0;

    Heartbeat() = default;
    explicit Heartbeat(std::uint64_t sequence_) : sequence(sequence_) {}
    bool operator==(const Heartbeat&) const = default;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, sequence);
    }
};

struct HeartbeatReply {
    static constexpr auto type = MessageType::heartbeat_reply;
    std::uint64_t sequence = 0;

    HeartbeatReply() = default;
    explicit HeartbeatReply(std::uint64_t sequence_) : sequence(sequence_) {}
    bool operator==(const HeartbeatReply&) const = default;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, sequence);
    }
};

enum class RefusalReason : std::uint8_t {
    bad_request,  ///< a value in the request is wrong
    no_such_job,
    no_such_file,  ///< no file of that digest, or no such chunk
    not_ready,     ///< ask again later: the job has no result yet
    full,          ///< a limit of the master is reached
    failed,        ///< the master's disk or memory failed
};
constexpr RefusalReason enum_last(RefusalReason) { return RefusalReason::failed; }
std::string_view name_of(RefusalReason reason);

/// master -> worker or submitter, the answer to any request (same request id) that is not granted.
struct Refusal {
    static constexpr auto type = MessageType::refusal;
    RefusalReason reason = RefusalReason::bad_request;
    std::string sentence;  ///< at most limits::sentence_bytes_max
    Digest file;           ///< that was asked for; zeros: it was not about a file

    Refusal() = default;
    Refusal(RefusalReason reason_, std::string sentence_, const Digest& file_ = {})
        : reason(reason_), sentence(std::move(sentence_)), file(file_) {}
    bool operator==(const Refusal&) const = default;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, reason, at_most(sentence, limits::sentence_bytes_max), file);
    }
};

}  // namespace lumenfarm::wire
