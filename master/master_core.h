#pragma once

#include "master/active_job.h"
#include "master/audits.h"
#include "master/effects.h"
#include "master/farm_counts.h"
#include "master/session.h"

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

/// The master without sockets, clocks, threads and disks (law 7): events go in, effects come out. Times are seconds of
/// one steady clock of the caller's. The connection answers heartbeats and closes when a peer is silent; the core takes
/// heartbeats as signs of life that extend leases.
namespace lumenfarm {

struct MasterPolicy {
    std::uint64_t fingerprint = 0;  ///< transport fingerprint that workers must have
    std::uint32_t epoch = 1;        ///< of this life of the master; larger than those of earlier ones
    JobId first_job = 1;            ///< jobs get this number and the following ones
    double set_target_seconds = 2;
    double flush_seconds = 2;                                     ///< maps: between two results of a tracing thread
    double checkpoint_seconds = 10;                               ///< between two snapshots of a job
    double dead_seconds = limits::dead_seconds;                   ///< a connection that is silent for so long is closed
    double reconnect_seconds = limits::reconnect_seconds;         ///< leases of a lost connection wait so long
    std::uint32_t results_in_flight = limits::results_in_flight;  ///< credit of a worker
    bool compress = false;                                        ///< workers compress their results
    double audit_fraction = 0;                                    ///< of the results are traced again by another worker
    std::uint64_t audit_key = 0;              ///< random: nobody knows which, nor what they are reduced to
    std::int64_t started_unix_seconds = 0;    ///< when the clock of the events was 0
    std::optional<double> recut_above;        ///< subspaces that share the work out less evenly are cut anew
    double recut_seconds = 10;                ///< between two looks at that
    std::uint64_t recut_hits = 20'000;        ///< fewer say nothing
    std::optional<double> keep_seconds;       ///< jobs that ended longer ago are removed
    std::optional<std::uint64_t> keep_bytes;  ///< while solutions take more, the job that ended first is removed
    std::string upstream;        ///< of a relay: its master above, to which submitters are sent; empty: none
    std::uint64_t instance = 0;  ///< of a relay: what it says in its own Hello
};

class MasterCore {
public:
    explicit MasterCore(const MasterPolicy& policy) : policy_(policy), next_job_(policy.first_job) {}

    /// A job of an earlier life. One that was running goes on first. REQUIRES: called before any other event.
    void restore(JobRecord record);

    Effects on_connect(SessionId session, const std::string& address, double now_s);
    Effects on_message(SessionId session, wire::Message message, std::uint64_t request_id, double now_s);
    Effects on_disconnect(SessionId session, double now_s);
    /// The answer to ServeManifest and ServeChunk: Manifest, Chunk or Refusal.
    Effects on_served(SessionId session, wire::Message reply, std::uint64_t request_id, double now_s);
    /// Something was discarded by the shell or the storage.
    Effects on_discarded(Discard reason, std::string sentence, double now_s);
    /// REQUIRES: called at least once a second.
    Effects tick(double now_s);
    /// No more leases, and nothing new is taken. What is on its way to the disk is waited for and answered, at most
    /// `wait_s`; then each job is to be kept in a snapshot, and sessions get a Goodbye (stopped()). The next life goes
    /// on with unfinished jobs. Called again it waits no longer than that call says.
    Effects stop(double now_s, double wait_s = limits::stop_seconds);
    bool stopped() const { return stopped_; }

    /// `missing`: chunks that have to be uploaded first; empty when the record was stored. An error refuses the job.
    Effects on_admitted(const Admit& admit, const Result<std::vector<std::uint32_t>>& missing, double now_s);
    Effects on_prepared(JobId job, Result<RecoveredJob> recovered, double now_s);
    Effects on_cut_measured(const MeasureCut& measure, const Evenness& evenness, double now_s);
    /// Whether it is there or not: the next one comes in time.
    Effects on_snapshot_stored(const StoreSnapshot& store, double now_s);
    // Errors of the following: no_space (the same is asked for again, later). The master does not outlive others.
    /// `stored`: what became of each job that has results among the tickets.
    Effects on_results_stored(std::span<const std::uint64_t> tickets, const Result<std::map<JobId, Merged>>& stored,
                              double now_s);
    Effects on_record_stored(const StoreRecord& store, const Result<void>& stored, double now_s);
    Effects on_put_aside(const PutAside& aside, double now_s);
    Effects on_removed(const RemoveJob& remove, const Result<void>& removed, double now_s);
    /// `left`: what is left of the job.
    Effects on_retracted(const Retract& retract, Result<Retracted> left, double now_s);
    /// `stored`: the record with the solution.
    Effects on_solution_stored(const StoreSolution& store, const Result<JobRecord>& stored, double now_s);

    /// Ends a job and keeps what is done: outstanding results are waited for, at most limits::finish_seconds.
    Effects cancel(JobId job, double now_s);

    // A relay's jobs are lent by a master above. Nothing of them is kept: StoreResult asks for their results to be
    // handed up, StoreLeases and StoreSnapshot are to be left alone.
    /// REQUIRES: there is no job of this number; no particle of `recovered` is lent yet.
    Effects begin_lent(JobRecord record, RecoveredJob recovered, double now_s);
    /// Particles to be traced, with those in flight of a subspace's range. False, and nothing changes: some of them are
    /// here still. REQUIRES: the job is lent.
    bool lend(JobId job, const ParticleRange& range, FlightQueues::Flights flights, std::uint64_t keep_threshold);
    /// Nobody is to trace them any more. Results that cover some of them will be refused.
    void withdraw(JobId job, const ParticleRange& range);
    /// Workers hand over what they have done of the job and return the rest; they get nothing more of it.
    Effects drain_lent(JobId job, double now_s);
    /// It is given out again.
    void resume_lent(JobId job);
    Effects end_lent(JobId job, double now_s);
    /// Of a lent job: ranges that were lost with one worker after the other.
    std::vector<ParticleRange> set_aside(JobId job) const;
    bool nobody_can_trace(JobId job) const;
    /// What the workers hold of it together. REQUIRES: it has subspaces.
    wire::PartsHeld parts_held(JobId job) const;
    std::uint32_t worker_threads() const;
    /// What was lent is given out now.
    Effects settle(double now_s) { return settle_and_take(now_s); }

    std::optional<wire::JobStatus> status(JobId job, double now_s) const;
    std::vector<wire::WorkerStatus> workers(double now_s) const;
    const JobRecord* record(JobId job) const;
    /// What the master does now, in one line for people.
    std::string summary(double now_s) const;
    std::uint64_t discarded(Discard reason) const { return counts_.discards.of(reason); }
    FarmCounts& counts() { return counts_; }  ///< the shell counts closes
    std::size_t staged_bytes() const { return staged_bytes_; }
    /// Who has what of a job; null unless it is active.
    const Ledger* ledger(JobId job) const;
    /// What of the books or of the bounds can't be. Nothing when all is well. Reads everything; for tests.
    std::optional<std::string> contradiction() const;

private:
    enum class Phase : std::uint8_t {
        queued,
        preparing,
        running,
        ending,  ///< no more sets; outstanding results are waited for, then it is stored or put aside
        put_aside,
        storing,
        over,
        removing,
    };
    struct Asker {
        SessionId session = 0;
        std::uint64_t request_id = 0;
        wire::JobAction action = wire::JobAction::pause;
    };
    struct LateRequest {
        SessionId session = 0;
        std::uint64_t request_id = 0;
        wire::ControlRequest request;
    };
    struct Job {
        JobRecord record;
        Phase phase = Phase::queued;
        std::unique_ptr<ActiveJob> active;
        std::optional<double> started_s;       ///< of the first lease
        std::set<MachineId> contributors;      ///< whose results were committed; at most limits::sessions_max
        double end_by_s = 0;                   ///< ending: outstanding results are waited for until then
        bool resumes = false;                  ///< it goes on before others begin
        bool was_put_aside = false;            ///< in this life: no lease of before is current
        bool lent = false;                     ///< by a master above
        bool gives_flights_up = false;         ///< cancelled, and nobody follows what is in flight
        std::optional<Digest> basis;           ///< it was over, and is to go on from this solution
        std::size_t results_on_their_way = 0;  ///< to the disk
        std::size_t records_on_their_way = 0;  ///< to the disk
        std::vector<Asker> askers;             ///< to be answered when the record lasts
        std::vector<LateRequest> late;         ///< came while the solution was being stored
        bool retracting = false;               ///< what liars have traced is being taken out on the disk
        bool retraction_waits = false;         ///< for space on the disk
        bool record_waits = false;             ///< for space on the disk
        bool solution_waits = false;           ///< for space on the disk
        JobEffort effort;                      ///< storing: for the solution
        double snapshot_s = 0;                 ///< when the last one was asked for, but for that of the end
        double next_snapshot_s = 0;            ///< infinite while one is on its way to the disk
        double measured_s = 0;                 ///< when its cut was looked at
        std::uint64_t cut_at_hits = 0;         ///< how many there were when it was cut
        std::vector<std::pair<double, std::uint64_t>> committed_at;  ///< for the rate

        bool may_begin() const { return phase == Phase::queued && !record.paused && !basis; }
    };

    /// A result on its way to the disk.
    struct Storing {
        JobId job = 0;
        WorkerId worker = 0;
        MachineId machine = 0;
        std::shared_ptr<const StagedResult> result;
        bool waiting_for_space = false;
        std::vector<std::pair<WorkerId, wire::ResultDone>> repeated;  ///< came with some of its particles meanwhile
    };

    // sessions (master_sessions.cpp)
    void greet(Session& session, wire::Hello hello, double now_s);
    void welcome_worker(Session& session, double now_s);
    void welcome(SessionId session);
    void send_off(SessionId session, wire::GoodbyeReason reason, Discard count, std::string sentence, double now_s);
    std::string peer_name(SessionId session) const;
    void forget(SessionId session, double now_s);
    void take_leases_back(const Session& session, double now_s);
    void extend_leases(const Session& session, double now_s);
    void dispatch(Session& session, wire::Message& message, std::uint64_t request_id, double now_s);

    // workers (master_work.cpp)
    void on(Session& session, const wire::Pull& pull, double now_s);
    void on(Session& session, const wire::Progress& progress, double now_s);
    void on(Session& session, const wire::ReturnLeases& returned, double now_s);
    void release_forgotten(Session& session, Job& job);
    /// What is returned for this reason is not to be given to that worker again.
    static bool is_refusal(wire::ReturnReason reason);
    template <class Part>
    void on_part(Session& session, Part part);
    void on(Session& session, wire::ResultDone& done, double now_s);
    void on(Session& session, const wire::PartsHeld& held, double now_s);
    void answer(WorkerId worker, JobId job, std::uint64_t result, const Outcome& outcome, double now_s);
    void tell(Session& session, Worker& worker, Job& job);
    void drop_open(Worker& worker);
    void give_work(double now_s);
    static Job* job_for(const Session& session, const std::vector<Job*>& jobs, Ledger::Hands hands, double now_s);
    bool has_suspect(Worker& worker);
    bool keeps_hands_free(const Session& session, const std::vector<Job*>& jobs, double now_s);
    bool nobody_can_trace(const Job& job) const;
    static std::uint64_t traced(const Job& job);
    Ledger::Hands hands_of(const Session& session) const;
    bool give_set(Session& session, Worker& worker, const std::vector<Job*>& jobs, std::uint64_t farm_threads,
                  double now_s);
    LeaseId new_lease();

    // which subspace a worker gets (master_subspaces.cpp)
    std::optional<std::uint32_t> next_source(const Job& job, const Worker& worker) const;
    static std::uint64_t particles_per_set_max(const Job& job, const Session& session, std::uint32_t source);
    static bool drains(const Job& job);
    static void begin_draining(Job& job, double now_s);
    static bool has_drained(const Job& job);
    void look_at_cut(Job& job, double now_s);

    // workers (master_work.cpp)
    void give_twins(double now_s);
    void give_twin(Session& session, Worker& worker, double now_s);
    double seconds_for(const Session& session, const Worker& worker, JobId id, std::uint64_t particles) const;
    void send_lease(Session& session, Worker& worker, Job& job, LeaseId lease, const ParticleRange& range, double now_s,
                    bool twin = false);
    std::uint64_t threads() const;

    // the end (master_stop.cpp)
    bool owes_answers() const;
    void stop_when_answered(double now_s);

    // what is on its way to the disk (master_storing.cpp)
    void store(Session& session, Job& job, StagedResult result);
    bool wait_for(WorkerId worker, const wire::ResultDone& done);
    void commit(std::uint64_t ticket, double now_s);
    void store_record(Job& job);
    void await_space(const Error& error, double now_s);
    void has_space(double now_s);
    void try_again(double now_s);
    void store_snapshot(Job& job, double now_s);
    /// Times as long as a snapshot took, the next one waits.
    static constexpr double snapshot_pause = 4;
    void collect_ended_leases();

    // jobs (master_jobs.cpp)
    void prepare_next(double now_s);
    Job* next_to_prepare();
    bool is_awaited(JobId job) const;
    void resume_workers(Job& job, double now_s);
    std::vector<Job*> running_in_order();
    static bool before(const Job& a, const Job& b);
    void end_if_finished(Job& job, double now_s);
    void end_with_solution(Job& job, double now_s);
    void put_aside(Job& job, double now_s);
    void end_activity(Job& job);
    void end_with_failure(Job& job, std::string sentence, double now_s);
    void not_prepared(Job& job, const Error& error, double now_s);
    static bool is_held_back(const JobRecord& job) { return job.paused && !job.status.sentence.empty(); }
    void tell_gone(Job& job);
    void sample_rate(Job& job, double now_s) const;
    std::int64_t unix_seconds(double now_s) const { return policy_.started_unix_seconds + std::int64_t(now_s); }
    JobEffort effort_of(const Job& job, double now_s) const;
    wire::JobStatus counts_of(const Job& job, double now_s) const;
    wire::JobStatus status_of(const Job& job, double now_s) const;
    Job* find(JobId job);

    // what is done to a job (master_control.cpp). Errors: bad_input.
    void on(SessionId session, std::uint64_t request_id, const wire::ControlRequest& request, double now_s);
    Result<void> control(Job& job, const wire::ControlRequest& request, double now_s);
    Result<void> pause(Job& job, double now_s);
    Result<void> resume(Job& job);
    void pause_if_stuck(Job& job, double now_s);
    void cancel_job(Job& job, double now_s);
    Result<void> extend(Job& job, std::uint64_t particles, double now_s);
    Result<void> remove(Job& job);
    void remove_old_jobs(double now_s);
    void wind_up(Job& job, double now_s);
    void answer_askers(Job& job);
    void take_late_requests(Job& job, double now_s);

    // results that are traced again (master_audit.cpp)
    void audit(const Job& job, const Storing& stored, std::uint64_t ticket, double now_s);
    bool give_audit_set(Session& session, Worker& worker, const std::vector<Job*>& jobs, double now_s);
    bool take_audit(Session& session, StagedResult& result, wire::ResultDone& done, double now_s);
    void condemn(MachineId liar, JobId found_in, Discard reason, const std::string& sentence, double now_s);
    void begin_retraction(Job& job, MachineId liar);
    void retract_if_quiet(Job& job);
    static bool has_liars(const Job& job) { return !job.record.liars.empty(); }
    bool is_questioned(const Job& job);

    // why a job is not over (master_why.cpp)
    std::string why(const Job& job, double now_s) const;
    std::string why_queued(const Job& job) const;
    std::string why_running(const Job& job, double now_s) const;

    // submitters (master_requests.cpp)
    void on(SessionId session, std::uint64_t request_id, wire::Submit submit, double now_s);
    void on(SessionId session, std::uint64_t request_id, const wire::StatusRequest& request, double now_s);
    void on(SessionId session, std::uint64_t request_id, const wire::WorkersRequest& request, double now_s);
    void on(SessionId session, std::uint64_t request_id, const wire::FetchRequest& request, double now_s);
    void refuse(SessionId session, std::uint64_t request_id, wire::RefusalReason reason, std::string sentence);
    void admit_next();
    JobRecord* find_key(std::uint64_t key);

    void send(SessionId session, wire::Message message, std::uint64_t request_id = 0);
    void count(Discard reason, std::uint64_t times = 1, std::string sentence = {});
    /// Gives work where there is some and room for it, and hands over what is to be done.
    Effects settle_and_take(double now_s);

    MasterPolicy policy_;
    std::map<SessionId, Session> sessions_;
    std::map<JobId, Job> jobs_;
    JobId next_job_;
    std::uint32_t leases_given_ = 0;
    std::map<std::uint64_t, Storing> storing_;  ///< by ticket
    std::uint64_t tickets_given_ = 0;
    std::optional<std::string> no_space_;  ///< the disk's sentence while it is full
    double retry_s_ = 0;                   ///< when what waits for space is tried again
    std::size_t staged_bytes_ = 0;
    bool stopping_ = false;
    bool stopped_ = false;
    double stop_by_s_ = 0;
    Audits audits_;
    std::set<MachineId> liars_;  ///< are kept out
    SessionId keeps_free_ = 0;   ///< it gets no sets until it has none, and then a suspect one
    double keeps_free_until_s_ = 0;
    std::deque<Admit> admissions_;  ///< the first is being carried out
    FarmCounts counts_;
    Effects effects_;
};

}  // namespace lumenfarm
