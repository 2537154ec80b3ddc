#include "master/master_core.h"

#include <algorithm>
#include <type_traits>
#include <utility>

/// The master's core: giving out sets and taking results.
namespace lumenfarm {

void MasterCore::on(Session& session, const wire::Pull& pull, double now_s) {
    Worker& worker = *session.worker();
    if (!worker.leases_stated)
        return send_off(session.id, wire::GoodbyeReason::protocol_error, Discard::protocol_error,
                        "a worker states its leases before it pulls", now_s);
    const std::uint64_t under_way = worker.leases_given - std::min(pull.leases, worker.leases_given);
    worker.wanted = pull.sets - static_cast<std::uint32_t>(std::min<std::uint64_t>(under_way, pull.sets));
    if (!session.is_relay()) return;
    worker.threads_per_set = pull.threads_per_set;
    session.hello.threads = pull.threads;
}

/// What a worker still holds when it comes. The master takes its other leases back; results of jobs that it names are
/// sent after a JobInfo.
void MasterCore::on(Session& session, const wire::Progress& progress, double now_s) {
    Worker& worker = *session.worker();
    if (worker.leases_stated) return;
    worker.leases_stated = true;
    std::set<JobId> named;
    for (const wire::LeaseProgress& lease : progress.leases) {
        worker.held.emplace(lease.lease, lease.job);
        named.insert(lease.job);
    }
    for (auto& [id, job] : jobs_) {
        if (!job.active) continue;
        release_forgotten(session, job);
        end_if_finished(job, now_s);
    }
    for (const JobId id : named) {
        Job* job = find(id);
        const bool gone = !job || job->record.paused || job->phase == Phase::over || job->phase == Phase::storing ||
                          job->phase == Phase::removing || (job->was_put_aside && !job->active);
        if (gone) {
            send(session.id, wire::JobGone(id));
            // it forgets them: should the job go on, they are nobody's
            for (const wire::LeaseProgress& lease : progress.leases)
                if (lease.job == id) worker.held.erase(lease.lease);
        } else if (job->active) {
            tell(session, worker, *job);
        } else {
            worker.awaited.insert(id);
        }
    }
    extend_leases(session, now_s);
}

/// A worker that came back does not know these leases any more.
void MasterCore::release_forgotten(Session& session, Job& job) {
    Ledger& ledger = job.active->ledger();
    std::uint64_t forgotten = 0;
    for (const LeaseId lease : ledger.leases_of(session.instance())) {
        if (session.worker()->held.contains(lease)) continue;
        ledger.release(lease);
        ++forgotten;
    }
    count(Discard::lease_forgotten, forgotten, "by " + peer_name(session.id));
}

void MasterCore::on(Session& session, const wire::ReturnLeases& returned, double now_s) {
    Worker& worker = *session.worker();
    for (const wire::LeaseRef& lease : returned.leases) {
        worker.held.erase(lease.lease);
        audits_.forget(session.machine(), lease.lease, now_s);
    }
    std::uint64_t taken_back = 0;
    for (auto& [id, job] : jobs_) {
        if (!job.active) continue;
        Ledger& ledger = job.active->ledger();
        for (const wire::LeaseRef& lease : returned.leases) {
            if (!ledger.held_by(session.instance(), lease.lease)) continue;
            // with a worker that nobody here knows, and that never comes back to be forgiven
            const WorkerId unknown = lease.lease;
            const bool lost = session.is_relay() && returned.reason == wire::ReturnReason::lost;
            lost ? ledger.lose(lease.lease, unknown, now_s) : ledger.release(lease.lease);
            ++job.record.status.leases_returned;
            ++taken_back;
            if (is_refusal(returned.reason)) worker.declined.insert(id);
        }
        end_if_finished(job, now_s);
    }
    count(Discard::lease_returned, taken_back, "by " + peer_name(session.id));
}

bool MasterCore::is_refusal(wire::ReturnReason reason) {
    return reason == wire::ReturnReason::no_scene || reason == wire::ReturnReason::tracer_failed;
}

namespace {

template <class Part>
constexpr bool only_of_maps = std::is_same_v<Part, wire::ResultMap> || std::is_same_v<Part, wire::ResultKept>;

}  // namespace

template <class Part>
void MasterCore::on_part(Session& session, Part part) {
    Worker& worker = *session.worker();
    const wire::PartId id = part.part;
    if (!worker.open || worker.open->job() != id.job || worker.open->number() != id.result) {
        if (worker.open) count(Discard::result_unfinished, 1, peer_name(session.id) + " began another result");
        drop_open(worker);
        worker.open.emplace(id.job, id.result);
    }
    StagedResult& open = *worker.open;
    const std::size_t before = open.bytes();
    const Job* job = find(id.job);
    if (!job || !job->active) {
        open.refuse_blamelessly("the job did not run when its result came");
    } else if (before + limits::frame_payload_bytes_max > limits::staged_result_bytes_max ||
               staged_bytes_ + limits::frame_payload_bytes_max > limits::staged_bytes_max) {
        if (!open.blameless()) count(Discard::staging_full, 1, peer_name(session.id) + " has to send it again");
        open.refuse_blamelessly("the master has no room for the result");
    } else if (only_of_maps<Part> && job->active->packing() == Packing::records) {
        // the sums of so many texels may not fit the memory of a relay
        open.refuse("sums came where hits are asked for");
    } else {
        open.add(job->record.spec, job->active->prepared(), std::move(part));
    }
    staged_bytes_ = staged_bytes_ - before + open.bytes();
}
template void MasterCore::on_part(Session&, wire::ResultHits);
template void MasterCore::on_part(Session&, wire::ResultMap);
template void MasterCore::on_part(Session&, wire::ResultKept);
template void MasterCore::on_part(Session&, wire::ResultFlights);
template void MasterCore::on_part(Session&, wire::ResultWork);

/// What a worker has of a job is what it is preferred for.
void MasterCore::on(Session& session, const wire::PartsHeld& held, double) {
    Worker& worker = *session.worker();
    const Job* job = find(held.job);
    if (!job || !job->active || !worker.told.contains(held.job)) return;
    worker.parts[held.job] = {{held.subspaces.begin(), held.subspaces.end()}, held.room_triangles, held.all};
}

void MasterCore::drop_open(Worker& worker) {
    if (!worker.open) return;
    staged_bytes_ -= worker.open->bytes();
    worker.open.reset();
}

void MasterCore::on(Session& session, wire::ResultDone& done, double now_s) {
    Worker& worker = *session.worker();
    StagedResult result(done.job, done.result);
    if (worker.open && worker.open->job() == done.job && worker.open->number() == done.result) {
        result = std::move(*worker.open);
    } else if (worker.open) {
        count(Discard::result_unfinished, 1, peer_name(session.id) + " ended another result");
    }
    drop_open(worker);
    Job* job = find(done.job);
    if (!job || !job->active)
        return answer(session.instance(), done.job, done.result, {wire::Verdict::job_gone, "the job is over"}, now_s);
    if (take_audit(session, result, done, now_s)) return;
    auto outcome = job->active->take(session.instance(), result, done);
    if (!outcome && wait_for(session.instance(), done)) return;
    if (!outcome) {
        outcome = {wire::Verdict::stale, "particles of it are on their way to the disk already"};
        job->active->take_back(session.instance(), claims_of(done));
    }
    if (outcome->verdict == wire::Verdict::accepted) {
        std::uint64_t traced = 0;
        for (const wire::Claim& claim : result.done().claims) traced += claim.range.count;
        worker.paces[result.job()].learn(traced, result.done().trace_seconds);
        worker.particles += result.done().balance.particles;
        return store(session, *job, std::move(result));
    }
    JobRecord& record = job->record;
    record.status.results_stale += outcome->verdict == wire::Verdict::stale;
    record.status.results_invalid += outcome->verdict == wire::Verdict::invalid;
    answer(session.instance(), done.job, done.result, *outcome, now_s);
    end_if_finished(*job, now_s);
}

namespace {

/// REQUIRES: not accepted.
Discard discard_of(wire::Verdict verdict) {
    switch (verdict) {
        case wire::Verdict::already_merged: return Discard::result_repeated;
        case wire::Verdict::stale: return Discard::result_stale;
        case wire::Verdict::job_gone: return Discard::result_of_gone_job;
        case wire::Verdict::accepted:
        case wire::Verdict::invalid: break;
    }
    return Discard::result_invalid;
}

}  // namespace

/// Says what became of a result, over whatever connection the worker has now; one that is away offers it again.
void MasterCore::answer(WorkerId worker, JobId job, std::uint64_t result, const Outcome& outcome, double now_s) {
    const auto found = std::find_if(sessions_.begin(), sessions_.end(), [&](const auto& entry) {
        return entry.second.worker() && entry.second.instance() == worker;
    });
    Session* session = found == sessions_.end() ? nullptr : &found->second;
    if (session) send(session->id, wire::ResultAck(job, result, outcome.verdict, outcome.sentence));
    if (outcome.verdict == wire::Verdict::accepted) return;
    const std::string from = session ? peer_name(session->id) : "a worker that is away";
    count(discard_of(outcome.verdict), 1, "job " + std::to_string(job) + ", from " + from + ": " + outcome.sentence);
    if (outcome.verdict != wire::Verdict::invalid) return;
    if (session && ++session->worker()->invalid_results >= limits::invalid_results_max)
        condemn(session->machine(), job, Discard::lied,
                std::to_string(limits::invalid_results_max) + " impossible results came, the last one (" +
                    outcome.sentence + ")",
                now_s);
}

std::uint64_t MasterCore::threads() const {
    std::uint64_t threads = 0;
    for (const auto& [id, session] : sessions_)
        if (session.worker()) threads += session.hello.threads;
    return std::max<std::uint64_t>(threads, 1);
}

void MasterCore::give_work(double now_s) {
    if (no_space_) return;
    const std::vector<Job*> jobs = running_in_order();
    const bool nothing = !audits_.any() && std::none_of(jobs.begin(), jobs.end(), [&](const Job* job) {
        return job->active->ledger().has_set(Ledger::Hands::empty, now_s);
    });
    if (nothing) return;
    const std::uint64_t farm_threads = threads();
    // one set to each in turn, so that the last sets are spread
    for (bool given = true; given;) {
        given = false;
        for (auto& [id, session] : sessions_) {
            Worker* worker = session.worker();
            if (worker && worker->wanted > 0) given |= give_set(session, *worker, jobs, farm_threads, now_s);
        }
    }
}

/// Of the jobs of the highest priority that have something for the worker, the one with the fewest leases: a lease is
/// a tracing thread for a while, so they have equal shares of the farm. The worker stays with the job it is at until
/// that is ahead by as many leases as the worker has threads, so that it seldom closes a result to change jobs.
MasterCore::Job* MasterCore::job_for(const Session& session, const std::vector<Job*>& jobs, Ledger::Hands hands,
                                     double now_s) {
    const Worker& worker = *session.worker();
    Job* fewest = nullptr;
    Job* current = nullptr;
    Job* suspect = nullptr;
    for (Job* job : jobs) {
        if (has_liars(*job) || worker.declined.contains(job->record.id())) continue;
        if (!job->active->ledger().has_set(hands, now_s)) continue;
        if (fewest && job->record.spec.priority < fewest->record.spec.priority) break;
        const auto leases = [](const Job* of) { return of->active->ledger().outstanding(); };
        if (!fewest || leases(job) < leases(fewest)) fewest = job;
        if (job->record.id() == worker.job) current = job;
        if (!suspect && hands == Ledger::Hands::empty && job->active->ledger().lost().needs_empty_hands(now_s))
            suspect = job;
    }
    // empty hands are rare
    if (suspect) return suspect;
    if (!current) return fewest;
    const std::uint64_t ahead = current->active->ledger().outstanding() - fewest->active->ledger().outstanding();
    return ahead * worker.threads_per_set <= session.hello.threads ? current : fewest;
}

/// Until a worker should have done so many particles more than it holds; 0 when its pace is not known. What it says of
/// its speed delays nothing for longer than limits::lease_seconds.
double MasterCore::seconds_for(const Session& session, const Worker& worker, JobId id, std::uint64_t particles) const {
    const auto pace_of = [&](JobId job) {
        const auto pace = worker.paces.find(job);
        return pace == worker.paces.end() ? 0 : pace->second.particles_per_s();
    };
    if (pace_of(id) == 0) return 0;
    const double set_s = static_cast<double>(particles) / pace_of(id);
    double all_s = set_s;
    for (const auto& [other, job] : jobs_)
        if (job.active && pace_of(other) > 0)
            all_s += static_cast<double>(job.active->ledger().owed_by(session.instance())) / pace_of(other);
    const double needed_s = std::max(set_s / worker.threads_per_set, all_s / std::max(session.hello.threads, 1u));
    return std::min(needed_s, limits::lease_seconds);
}

bool MasterCore::give_set(Session& session, Worker& worker, const std::vector<Job*>& jobs, std::uint64_t farm_threads,
                          double now_s) {
    if (has_suspect(worker)) return false;
    const Ledger::Hands hands = hands_of(session);
    if (hands == Ledger::Hands::full && keeps_hands_free(session, jobs, now_s)) return false;
    Job* job = job_for(session, jobs, hands, now_s);
    const bool suspect = job && hands == Ledger::Hands::empty && job->active->ledger().lost().needs_empty_hands(now_s);
    if (!suspect && give_audit_set(session, worker, jobs, now_s)) return true;
    if (!job) return false;
    Ledger& ledger = job->active->ledger();
    const SetPolicy policy{job->record.spec.particles_per_set, policy_.set_target_seconds};
    Pace& pace = worker.paces[job->record.id()];
    const std::uint64_t unleased = ledger.unleased() + ledger.lost().waiting_particles();
    const std::uint64_t sets_at_once = std::max<std::uint64_t>(session.hello.threads / worker.threads_per_set, 1);
    std::optional<std::uint32_t> source = ledger.next_light();
    SetDemand demand{unleased, farm_threads, sets_at_once, 1};
    const PreparedJob& prepared = job->active->prepared();
    if (source && !prepared.subspaces) demand.light_cost = prepared.light_costs[*source];
    std::uint64_t size = next_set_size(policy, pace, demand);
    size = std::min(size * worker.threads_per_set, limits::particles_per_set_max);
    if (prepared.subspaces) {
        source = next_source(*job, worker);
        if (!source && !ledger.lost().ready(now_s, hands == Ledger::Hands::empty)) return false;
        size = std::min(size, particles_per_set_max(*job, session, source.value_or(none)));
    }
    const LeaseId id = new_lease();
    const double due_s = now_s + seconds_for(session, worker, job->record.id(), size);
    const auto given =
        ledger.lease(id, session.instance(), hands, size, now_s, now_s + limits::lease_seconds, source, due_s);
    if (!given) return false;
    if (given->alone) worker.alone = id;
    if (!pace.known()) pace.give();
    send_lease(session, worker, *job, id, given->range, now_s);
    return true;
}

/// Whether it has a set that is suspected of killing workers, and is to have nothing else meanwhile.
bool MasterCore::has_suspect(Worker& worker) {
    if (worker.alone == 0) return false;
    const bool lasts = std::any_of(jobs_.begin(), jobs_.end(), [&](const auto& entry) {
        return entry.second.active && entry.second.active->ledger().holds(worker.alone);
    });
    if (!lasts) worker.alone = 0;
    return lasts;
}

/// A set that waits for empty hands would wait for ever where every worker always has something: one worker after the
/// other, for a while, gets nothing until it has finished what it has.
bool MasterCore::keeps_hands_free(const Session& session, const std::vector<Job*>& jobs, double now_s) {
    const Job* job = job_for(session, jobs, Ledger::Hands::empty, now_s);
    if (!job || !job->active->ledger().lost().needs_empty_hands(now_s)) return false;
    if (now_s >= keeps_free_until_s_ || !sessions_.contains(keeps_free_)) {
        const auto next = std::find_if(sessions_.upper_bound(keeps_free_), sessions_.end(),
                                       [](const auto& entry) { return entry.second.worker(); });
        keeps_free_ = next == sessions_.end() ? session.id : next->first;
        keeps_free_until_s_ = now_s + limits::lease_seconds;
    }
    return keeps_free_ == session.id;
}

/// Every worker has declined it.
bool MasterCore::nobody_can_trace(const Job& job) const {
    std::uint64_t workers = 0, unable = 0;
    for (const auto& [id, session] : sessions_) {
        if (!session.worker()) continue;
        ++workers;
        unable += session.worker()->declined.contains(job.record.id());
    }
    return workers > 0 && unable == workers;
}

Ledger::Hands MasterCore::hands_of(const Session& session) const {
    const bool has_lease = std::any_of(jobs_.begin(), jobs_.end(), [&](const auto& entry) {
        return entry.second.active && entry.second.active->ledger().has_lease(session.instance());
    });
    const bool empty = !has_lease && !audits_.busy(session.machine());
    return empty ? Ledger::Hands::empty : Ledger::Hands::full;
}

LeaseId MasterCore::new_lease() { return lease_id(policy_.epoch, ++leases_given_); }

void MasterCore::tell(Session& session, Worker& worker, Job& job) {
    const JobId id = job.record.id();
    if (!worker.told.insert(id).second) return;
    JobSpec spec = job.record.spec;
    spec.packing = job.active->packing();
    const WorkerFiles& files = job.active->files();
    send(session.id, wire::JobInfo(id, files.first, files.first_bytes, std::move(spec), job.active->prepared().texel_m,
                                   policy_.flush_seconds));
}

void MasterCore::send_lease(Session& session, Worker& worker, Job& job, LeaseId lease, const ParticleRange& range,
                            double now_s, bool twin) {
    const JobId id = job.record.id();
    tell(session, worker, job);
    if (!job.started_s) job.started_s = now_s;
    worker.count_lease(id);
    effects_.push_back(StoreLeases{{{id, {lease, session.instance(), range}}}, {}});
    wire::Lease message(lease, policy_.epoch, id, range, job.active->keep_threshold());
    message.apart = twin;
    message.flights = job.active->flights(range);
    send(session.id, std::move(message));
}

/// Idle workers trace again what stragglers still owe, when nothing else is left to do.
void MasterCore::give_twins(double now_s) {
    if (stopping_ || no_space_) return;
    for (auto& [id, session] : sessions_) {
        Worker* worker = session.worker();
        if (!worker || worker->wanted == 0) continue;
        if (hands_of(session) == Ledger::Hands::empty) give_twin(session, *worker, now_s);
    }
}

void MasterCore::give_twin(Session& session, Worker& worker, double now_s) {
    for (Job* job : running_in_order()) {
        Ledger& ledger = job->active->ledger();
        if (worker.declined.contains(job->record.id())) continue;
        if (ledger.unleased() > 0) return;
        const LeaseId lease = new_lease();
        const double late_s = now_s - limits::straggler_targets * policy_.set_target_seconds;
        const std::uint64_t most =
            job->active->prepared().subspaces ? particles_per_set_max(*job, session, 0) : limits::particles_per_set_max;
        const auto twin =
            ledger.lease_twin(lease, session.instance(), late_s, now_s, now_s + limits::lease_seconds, most);
        if (!twin) continue;
        if (twin->alone) worker.alone = lease;
        return send_lease(session, worker, *job, lease, twin->range, now_s, true);
    }
}

}  // namespace lumenfarm
