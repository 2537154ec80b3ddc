#pragma once

#include "master/master_core.h"
#include "relay/effects.h"
#include "relay/lent_sets.h"
#include "relay/merged_result.h"
#include "worker/lease_returns.h"
#include "worker/result_outbox.h"
#include "worker/scene_fetch.h"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

/// A relay without sockets, clocks, threads and disks (law 7): to the master above a worker, to its own workers a
/// master (docs/relays.md). It pulls large sets, lends them to a MasterCore of its own, adds up what comes back and
/// hands that up. Events go in, effects come out. Times are seconds of one steady clock of the caller's.
namespace lumenfarm::relay {

struct RelayIdentity {
    std::string name;
    std::uint64_t instance = 0;  ///< random, of this process
    std::string isa;
    std::uint64_t fingerprint = 0;
};

class RelayCore {
public:
    /// `farm`: of the MasterCore; its upstream says where the master above is.
    /// `bytes_in_flight`: of results handed up and not answered, beyond which workers wait for their answers.
    RelayCore(const RelayIdentity& identity, MasterPolicy farm, double drain_seconds = limits::drain_seconds,
              std::size_t bytes_in_flight = limits::relay_bytes_in_flight);

    // The master above
    Effects on_upstream_open(double now_s);
    Effects on_upstream_message(wire::Message message, double now_s);
    /// Work goes on. `goodbye`: the master's, if it said one.
    Effects on_upstream_lost(const std::optional<wire::Goodbye>& goodbye, double now_s);
    /// The next part of a result, to be asked for while the connection has room.
    std::optional<wire::Message> next_bulk();

    // Workers and submitters
    Effects on_connect(SessionId session, const std::string& address, double now_s);
    Effects on_message(SessionId session, wire::Message message, std::uint64_t request_id, double now_s);
    Effects on_disconnect(SessionId session, double now_s);
    /// Something was discarded by the shell.
    Effects on_discarded(lumenfarm::Discard reason, std::string sentence, double now_s);

    // The disk
    Effects on_served(SessionId session, wire::Message reply, std::uint64_t request_id, double now_s);
    Effects on_file_kept(const Digest& file, const Result<void>& kept, double now_s);
    Effects on_prepared(const wire::JobInfo& info, Result<Preparation> prepared, double now_s);

    /// REQUIRES: called at least once a second.
    Effects tick(double now_s);
    /// Pull no more, let the workers hand over what they have, hand it up, return the rest. Finished comes within the
    /// drain time.
    Effects drain(double now_s);
    /// As drain(), and Finished comes at once.
    Effects end_now(double now_s);
    /// A Goodbye for everybody below, once it is Finished.
    Effects dismiss(double now_s);

    bool welcome() const { return welcome_; }
    std::uint64_t particles_merged() const { return particles_merged_; }
    /// What the relay does now, in one line for people.
    std::string summary(double now_s) const;
    const MasterCore& farm() const { return farm_; }
    FarmCounts& farm_counts() { return farm_.counts(); }  ///< the shell counts closes of workers
    worker::WorkerCounts& counts() { return counts_; }    ///< and those of the master above
    /// What of the books or of the bounds can't be. Nothing when all is well; for tests.
    std::optional<std::string> contradiction() const;

private:
    /// The first results go up soon, so that the master learns how large sets may be; each may wait twice as long as
    /// the one before, up to the job's flush_seconds.
    static constexpr double first_flush_s = 0.02;

    enum class Phase : std::uint8_t { fetching, preparing, running, failed };
    struct Job {
        wire::JobInfo info;
        Phase phase = Phase::fetching;
        bool confirmed = false;                 ///< the master has told of it in this session
        Digest needs;                           ///< fetching: this file
        std::map<Digest, std::uint64_t> files;  ///< that it and its workers may ask for, and their bytes
        std::vector<wire::Lease> waiting;       ///< until it runs
        LentSets sets;
        std::optional<MergedResult> open;  ///< once it runs
        double open_since_s = 0;
        double flush_s = first_flush_s;  ///< most time that sums wait
        std::optional<wire::PartsHeld> parts_told;
        std::optional<double> drain_by_s;  ///< then its sets go back
    };
    /// A worker's request for a file that is on its way.
    using Request = ServeManifest;

    // jobs and their sets (relay_jobs.cpp)
    void greet(const wire::Welcome& welcome, double now_s);
    void take_job(const wire::JobInfo& info, double now_s);
    void take_lease(wire::Lease lease);
    void lend(Job& job, wire::Lease lease);
    void drop_job(JobId id, double now_s);
    void drop_jobs_not_held(double now_s);
    void fail_job(Job& job, wire::ReturnReason reason);
    void give_back(Job& job, const LentSet& set, wire::ReturnReason reason);
    void give_all_back(Job& job, wire::ReturnReason reason);
    void give_back_what_is_hopeless(Job& job);
    void give_back_what_nobody_traces(double now_s);
    bool waits_for_room(JobId id) const;
    void drain_job(Job& job, double now_s, double drain_by_s);
    void end_drain_if_done(JobId id, Job& job, double now_s);
    std::uint64_t sets_ahead(JobId id, const Job& job) const;
    std::vector<wire::LeaseProgress> leases_held() const;

    // results (relay_results.cpp)
    void merge_pending(double now_s);
    void answer_pending(JobId id, double now_s);
    void merge(Job& job, const StagedResult& result, const std::vector<wire::Claim>& claims, double now_s);
    void close(Job& job);
    void close_what_is_due(double now_s);
    void take_ack(const wire::ResultAck& ack);
    void leave(Job& job, const std::vector<wire::Claim>& claims);
    bool claimed(std::uint64_t lease) const;

    // files (relay_files.cpp)
    void need(Job& job, const Digest& file);
    void want(const Digest& file);
    void serve(const Request& request);
    std::optional<std::uint64_t> bytes_of(const Digest& file) const;
    void fetch_next();
    void take_requests(const Result<std::vector<wire::Message>>& requests);
    void fail_fetch(Digest file, const std::string& why);
    void refuse(const Request& request, wire::RefusalReason reason, const std::string& why);
    void refuse_all(const Digest& file, const std::string& why);
    void prepare(Job& job);

    void tell_parts();
    void pull();
    void send_returns();
    void begin_drain(double now_s);
    void finish_if_drained(double now_s);
    void route(lumenfarm::Effects effects);
    void count(worker::Discard reason, std::uint64_t times, std::string sentence);
    void ignore(const wire::Message& message);
    void send(wire::Message message) { effects_.push_back(SendUp{std::move(message)}); }
    Effects settle_and_take(double now_s);

    RelayIdentity identity_;
    double drain_seconds_;
    double reconnect_seconds_;
    std::size_t bytes_in_flight_;
    MasterCore farm_;
    bool welcome_ = false;
    std::optional<double> lost_s_;      ///< since when there is no connection upwards
    std::optional<double> deserted_s_;  ///< since when there is no worker
    std::map<JobId, Job> jobs_;
    std::deque<StoreResult> pending_;  ///< whole results of workers that wait for room
    worker::ResultOutbox results_;     ///< handed up, or on their way
    worker::LeaseReturns returns_;
    std::optional<worker::SceneFetch> fetch_;
    std::deque<Digest> wanted_;  ///< files to be fetched after that
    std::set<Digest> keeping_;   ///< fetched, and on their way to the disk
    std::set<Digest> kept_;
    std::vector<Request> requests_;                     ///< that wait for a file
    wire::Pull wished_;                                 ///< what the master believes that this relay has room for
    std::uint64_t leases_received_ = 0;                 ///< in this session
    std::uint32_t credit_ = limits::results_in_flight;  ///< results that may be under way; the master's
    std::optional<double> drain_by_s_;
    bool finished_ = false;
    std::uint64_t particles_merged_ = 0;
    worker::WorkerCounts counts_;
    Effects effects_;
};

}  // namespace lumenfarm::relay
