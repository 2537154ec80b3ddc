#include "master/master_core.h"

#include "common/transport/fingerprint.h"

#include <xxhash.h>

#include <type_traits>
#include <utility>

/// The master's core: sessions, from Hello to Goodbye.
namespace lumenfarm {

namespace {

/// Messages that only a worker sends.
template <class M>
inline constexpr bool of_worker =
    std::is_same_v<M, wire::Pull> || std::is_same_v<M, wire::Progress> || std::is_same_v<M, wire::PartsHeld> ||
    std::is_same_v<M, wire::ReturnLeases> || std::is_same_v<M, wire::ResultDone>;
template <class M>
inline constexpr bool is_part =
    std::is_same_v<M, wire::ResultHits> || std::is_same_v<M, wire::ResultMap> || std::is_same_v<M, wire::ResultKept> ||
    std::is_same_v<M, wire::ResultFlights> || std::is_same_v<M, wire::ResultWork>;
/// Messages that only a submitter sends.
template <class M>
inline constexpr bool of_submitter = std::is_same_v<M, wire::Submit> || std::is_same_v<M, wire::StatusRequest> ||
                                     std::is_same_v<M, wire::WorkersRequest> ||
                                     std::is_same_v<M, wire::ControlRequest> || std::is_same_v<M, wire::FetchRequest>;

/// A relay has no jobs of its own.
template <class M>
inline constexpr bool is_for_upstream =
    std::is_same_v<M, wire::Submit> || std::is_same_v<M, wire::ControlRequest> || std::is_same_v<M, wire::FetchRequest>;

}  // namespace

MachineId Session::machine() const {
    const std::string who = hello.name + "\n" + address.substr(0, address.rfind(':'));
    return XXH3_64bits(who.data(), who.size());
}

void MasterCore::send_off(SessionId session, wire::GoodbyeReason reason, Discard why, std::string sentence,
                          double now_s) {
    count(why, 1, peer_name(session) + " is sent off: " + sentence);
    send(session, wire::Goodbye(reason, std::move(sentence)));
    effects_.push_back(Close{session});
    forget(session, now_s);
}

/// For logs.
std::string MasterCore::peer_name(SessionId session) const {
    const auto found = sessions_.find(session);
    if (found == sessions_.end()) return "a peer that is gone";
    const std::string& name = found->second.hello.name;
    return found->second.address + (name.empty() ? "" : " '" + name + "'");
}

void MasterCore::forget(SessionId session, double now_s) {
    const auto found = sessions_.find(session);
    if (found == sessions_.end()) return;
    if (Worker* worker = found->second.worker()) {
        if (worker->open) count(Discard::result_unfinished, 1, peer_name(session) + " is gone");
        drop_open(*worker);
        audits_.forget(found->second.machine(), now_s);
        // the worker may come back and go on with what it has
        for (auto& [id, job] : jobs_)
            if (job.active) job.active->ledger().shorten(found->second.instance(), now_s + policy_.reconnect_seconds);
    }
    sessions_.erase(found);
}

void MasterCore::greet(Session& session, wire::Hello hello, double now_s) {
    using enum wire::GoodbyeReason;
    if (hello.protocol < wire::protocol_oldest)
        return send_off(session.id, unsupported_protocol, Discard::unsupported_protocol,
                        "this master speaks protocol " + std::to_string(wire::protocol_oldest) + " to " +
                            std::to_string(wire::protocol_newest) + ", not " + std::to_string(hello.protocol),
                        now_s);
    session.hello = std::move(hello);
    if (wire::pulls_work(session.hello.role)) return welcome_worker(session, now_s);
    session.role = Submitter{};
    welcome(session.id);
}

void MasterCore::welcome(SessionId session) {
    wire::Welcome welcome(session);
    welcome.dead_seconds = policy_.dead_seconds;
    welcome.heartbeat_seconds = policy_.dead_seconds / limits::heartbeats_per_dead;
    welcome.reconnect_seconds = policy_.reconnect_seconds;
    welcome.results_in_flight = policy_.results_in_flight;
    welcome.compress = policy_.compress;
    send(session, std::move(welcome));
}

void MasterCore::welcome_worker(Session& session, double now_s) {
    using enum wire::GoodbyeReason;
    const wire::Hello& hello = session.hello;
    if (session.is_relay() && hello.instance == policy_.instance)
        return send_off(session.id, refused, Discard::own_upstream,
                        "this relay is its own upstream; --upstream is to name its master", now_s);
    if (hello.fingerprint == paced_fingerprint(policy_.fingerprint))
        return send_off(session.id, refused, Discard::fingerprint_differs,
                        "paced workers, and a master or relay with --paced-workers, take part in measurements only: "
                        "this is one and its peer is not",
                        now_s);
    if (hello.fingerprint != policy_.fingerprint)
        return send_off(session.id, refused, Discard::fingerprint_differs,
                        "this worker's tracer gives other bits than the master's; install the same version", now_s);
    if ((hello.threads == 0 && !session.is_relay()) || hello.threads > limits::threads_per_worker_max)
        return send_off(session.id, refused, Discard::no_threads,
                        "a worker has 1 to " + std::to_string(limits::threads_per_worker_max) + " threads, not " +
                            std::to_string(hello.threads),
                        now_s);
    if (liars_.contains(session.machine()))
        return send_off(session.id, refused, Discard::quarantined,
                        "what this machine had traced was found wrong: look at its memory; it is kept out until the "
                        "master starts again",
                        now_s);
    std::optional<SessionId> older;
    for (const auto& [id, other] : sessions_)
        if (id != session.id && other.worker() && other.instance() == session.instance()) older = id;
    if (older) send_off(*older, replaced, Discard::replaced, "this worker opened a newer session", now_s);
    session.role = Worker{};
    for (auto& [id, job] : jobs_)
        if (job.active) job.active->ledger().forgive(session.instance(), now_s);
    welcome(session.id);
}

void MasterCore::dispatch(Session& session, wire::Message& message, std::uint64_t request_id, double now_s) {
    const auto unexpected = [&] {
        send_off(session.id, wire::GoodbyeReason::protocol_error, Discard::protocol_error,
                 std::string(wire::name_of(message)) + " is not expected here", now_s);
    };
    const bool submitter = std::holds_alternative<Submitter>(session.role);
    std::visit(
        [&]<class M>(M& m) {
            if constexpr (std::is_same_v<M, wire::Goodbye>) {
                if (m.reason == wire::GoodbyeReason::done) take_leases_back(session, now_s);
                effects_.push_back(Close{session.id});
                forget(session.id, now_s);
            } else if constexpr (std::is_same_v<M, wire::Hello>) {
                std::holds_alternative<Greeting>(session.role) ? greet(session, std::move(m), now_s) : unexpected();
            } else if (std::holds_alternative<Greeting>(session.role)) {
                unexpected();
            } else if constexpr (std::is_same_v<M, wire::Heartbeat> || std::is_same_v<M, wire::HeartbeatReply>) {
                extend_leases(session, now_s);
            } else if constexpr (std::is_same_v<M, wire::ManifestRequest>) {
                effects_.push_back(ServeManifest{session.id, request_id, m.file});
            } else if constexpr (std::is_same_v<M, wire::ChunkRequest>) {
                effects_.push_back(ServeChunk{session.id, request_id, m.file, m.index});
            } else if constexpr (of_submitter<M>) {
                submitter&& is_for_upstream<M> && !policy_.upstream.empty()
                    ? refuse(session.id, request_id, wire::RefusalReason::bad_request,
                             "this is a relay: ask its master at " + policy_.upstream)
                : submitter ? on(session.id, request_id, std::move(m), now_s)
                            : unexpected();
            } else if constexpr (std::is_same_v<M, wire::Chunk>) {
                submitter ? effects_.push_back(StoreChunk{std::move(m)}) : unexpected();
            } else if constexpr (is_part<M>) {
                session.worker() ? on_part(session, std::move(m)) : unexpected();
            } else if constexpr (of_worker<M>) {
                session.worker() ? on(session, m, now_s) : unexpected();
            } else {
                unexpected();
            }
        },
        message);
}

void MasterCore::extend_leases(const Session& session, double now_s) {
    if (!session.worker()) return;
    for (auto& [id, job] : jobs_)
        if (job.active) job.active->ledger().extend(session.instance(), now_s + limits::lease_seconds);
}

/// A worker that ends does not come back for what it has.
void MasterCore::take_leases_back(const Session& session, double now_s) {
    if (!session.worker()) return;
    for (auto& [id, job] : jobs_) {
        if (!job.active) continue;
        Ledger& ledger = job.active->ledger();
        const std::vector<LeaseId> leases = ledger.leases_of(session.instance());
        for (const LeaseId lease : leases) ledger.release(lease);
        job.record.status.leases_returned += leases.size();
        count(Discard::lease_returned, leases.size());
        end_if_finished(job, now_s);
    }
}

std::vector<wire::WorkerStatus> MasterCore::workers(double now_s) const {
    std::vector<wire::WorkerStatus> all;
    for (const auto& [id, session] : sessions_) {
        const Worker* worker = session.worker();
        if (!worker) continue;
        wire::WorkerStatus status;
        status.session = id;
        status.name = session.hello.name;
        status.address = session.address;
        status.role = session.hello.role;
        status.threads = session.hello.threads;
        status.memory_bytes = session.hello.memory_bytes;
        status.isa = session.hello.isa;
        for (const auto& [job_id, job] : jobs_) {
            if (!job.active) continue;
            const auto leases = job.active->ledger().leases_of(session.instance());
            if (!leases.empty()) status.job = job_id;
            status.leases += static_cast<std::uint32_t>(leases.size());
        }
        status.state = status.leases > 0 ? wire::WorkerState::working : wire::WorkerState::idle;
        status.particles = worker->particles;
        if (const auto pace = worker->paces.find(status.job); pace != worker->paces.end())
            status.particles_per_second = pace->second.particles_per_s() * session.hello.threads;
        status.connected_seconds = now_s - session.connected_s;
        status.silent_seconds = now_s - session.heard_s;
        all.push_back(std::move(status));
    }
    return all;
}

}  // namespace lumenfarm
