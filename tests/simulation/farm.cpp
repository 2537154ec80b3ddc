#include "tests/simulation/farm.h"

#include "common/scene/scene_file.h"
#include "common/solution/solution_file.h"
#include "common/support/ensure.h"
#include "tests/simulation/reference.h"
#include "tests/simulation/small_scene.h"

#include <algorithm>
#include <utility>

namespace lumenfarm::testing {

namespace {

constexpr double absurd_s = 50'000;
constexpr double sleep_s = 40'000;
constexpr std::uint64_t first_client_key = 1'000'000;

bool over(const JobRecord* record) { return record && record->over(); }

}  // namespace

Farm::Farm(const std::vector<ClientPlan>& clients, const FarmOptions& options)
    : options_(options), world_(options.seed), checks_(world_, clients.size()) {
    world_.network.set_latency(options.latency_s, options.latency_spike_s);
    for (std::size_t i = 0; i < options.relays; ++i) {
        const bool second = i == 1 && options.relay_of_relay;
        relays_.emplace_back(world_, checks_, i, second ? relays_.front().below() : world_.network,
                             options.relay_bytes_in_flight);
        relays_.back().below().set_latency(options.latency_s, options.latency_spike_s);
    }
    for (std::size_t i = 0; i < options.workers; ++i)
        workers_.emplace_back(world_, checks_, network_of(i), i, options.threads, options.memory_bytes,
                              i < options.parts_only);
    for (std::size_t i = 0; i < clients.size(); ++i)
        clients_.push_back(std::make_unique<SimulatedClient>(world_, i, first_client_key + i, clients[i]));
    if (options.first_lies_one_in > 0) {
        workers_.front().lie(options.first_lies_one_in);
        checks_.somebody_lies();
    }
    master_ = std::make_unique<SimulatedMaster>(world_, checks_, options.seed, options.master);
    for (std::size_t i = 0; i < relays_.size(); ++i)
        world_.clock.at(world_.chance.uniform(0, 1), [this, i] { start_relay(i); });
    for (std::size_t i = 0; i < workers_.size(); ++i)
        world_.clock.at(world_.chance.uniform(0, 1), [this, i] { start_worker(i); });
    begin_storms();
}

std::optional<std::size_t> Farm::relay_of(std::size_t worker) const {
    // the last relay has the first worker, so that a farm of one worker tries it
    const std::size_t place = worker % (relays_.size() + 1);
    return place == relays_.size() ? std::nullopt : std::optional(relays_.size() - 1 - place);
}

SimulatedNetwork& Farm::network_of(std::size_t worker) {
    const auto relay = relay_of(worker);
    return relay ? relays_[*relay].below() : world_.network;
}

void Farm::start_relay(std::size_t index) {
    if (!relays_[index].alive()) relays_[index].start(next_instance_++);
}

void Farm::start_worker(std::size_t index) {
    if (workers_[index].core()) return;
    const bool sleeps = options_.one_worker_sleeps && index == 0;
    workers_[index].start(next_instance_++,
                          sleeps ? sleep_s : world_.chance.uniform(options_.slice_s_min, options_.slice_s_max));
}

std::size_t Farm::workers_finished() const {
    return static_cast<std::size_t>(
        std::count_if(workers_.begin(), workers_.end(), [](const auto& worker) { return worker.drained(); }));
}

wire::JobState Farm::state() const { return master().record(clients_.front()->job())->status.state; }

bool Farm::over() const {
    const MasterCore* core = std::as_const(*master_).core();
    return core && std::all_of(clients_.begin(), clients_.end(), [&](const auto& client) {
               return client->content() && testing::over(core->record(client->job()));
           });
}

bool Farm::run() {
    while (checks_.violations().empty() && !over()) {
        world_.clock.step();
        check_step();
    }
    if (checks_.violations().empty()) check_results();
    return checks_.violations().empty();
}

// What must hold

void Farm::check_step() {
    if (const MasterCore* core = master_->core()) checks_.after_event(*core);
    for (const SimulatedWorker& worker : workers_) {
        if (!worker.core()) continue;
        if (const auto fault = worker.core()->contradiction()) checks_.violated(*fault);
    }
    for (const SimulatedRelay& relay : relays_) {
        if (!relay.alive()) continue;
        if (const auto fault = relay.core()->contradiction()) checks_.violated("a relay's " + *fault);
    }
    if (!master_is_calm()) master_calm_since_s_ = now_s();
    check_progress();
    check_answers();
    if (now_s() > absurd_s) checks_.violated("the farm does not end");
}

void Farm::check_progress() {
    std::uint64_t achieved = master_->lives();
    bool waiting = false;
    const MasterCore* core = master_->core();
    for (const auto& client : clients_) {
        const auto job = checks_.job_of(client->instance());
        if (!job || !core) continue;
        const Ledger* ledger = core->ledger(*job);
        const bool ended = testing::over(core->record(*job));
        achieved += (ledger ? committed_in_all(*ledger) : 0) + (ended ? limits::particles_max : 0);
        waiting = waiting || !ended;
    }
    if (std::exchange(progress_, achieved) != achieved || !waiting) progress_s_ = now_s();
    double fit_since_s = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < workers_.size(); ++i)
        if (workers_[i].traces()) fit_since_s = std::min(fit_since_s, calm_since_s(i));
    const double since_s = std::max({progress_s_, fit_since_s, master_calm_since_s_});
    if (now_s() <= since_s + progress_seconds_max * static_cast<double>(1 + relays_.size())) return;
    std::string why;
    for (const auto& client : clients_)
        if (const auto status = core ? core->status(client->job(), now_s()) : std::nullopt)
            why += "; " + status->sentence;
    checks_.violated("nothing is achieved for " + std::to_string(progress_seconds_max) +
                     " s, and a worker lives and is reached" + why);
}

/// Since when neither it nor a relay above it was in trouble.
double Farm::calm_since_s(std::size_t worker) {
    double since_s = calm_since_s_[workers_[worker].host()];
    const auto relay = relay_of(worker);
    for (std::size_t i = 0; relay && i <= *relay; ++i) {
        if (!relays_[i].alive()) return std::numeric_limits<double>::infinity();
        since_s = std::max({since_s, relays_[i].up_since_s(), calm_since_s_[relays_[i].host()]});
    }
    return since_s;
}

void Farm::check_answers() {
    for (const auto& client : clients_) {
        const auto asks_since_s = client->asks_since_s();
        if (!asks_since_s) continue;
        const double since_s = std::max({*asks_since_s, calm_since_s_[client->host()], master_calm_since_s_});
        if (now_s() > since_s + answer_seconds_max) checks_.violated("a client is not answered");
    }
}

Solution Farm::solution_of(const SimulatedClient& client) {
    const JobRecord* record = master().record(client.job());
    ensure(record && record->has_solution, "the job has ended with a solution");
    const auto bytes = master_->files().read(record->solution_file).value();
    return decode_solution(bytes, small_scene(), record->status.scene).value();
}

/// Each job has the bits that its committed particles give, and these are all unless it was cancelled.
void Farm::check_results() {
    for (const auto& client : clients_) {
        const JobRecord& record = *master().record(client->job());
        const std::string name = "job " + std::to_string(client->job());
        if (record.status.state == wire::JobState::failed)
            checks_.violated(name + " failed: " + record.status.sentence);
        if (!record.has_solution) {
            for (const IntervalSet& light : checks_.acknowledged(client->job()))
                if (light.size() > 0) checks_.violated(name + " has lost its results");
            continue;
        }
        const JobSpec& spec = record.spec;
        if (spec.particles < client->particles()) checks_.violated(name + " was extended, and is not");
        const Solution solution = solution_of(*client);
        if (record.status.state == wire::JobState::done && solution.balance.particles != spec.particles)
            checks_.violated(name + " is done, and not complete");
        const auto& acknowledged = checks_.acknowledged(client->job());
        for (std::size_t light = 0; light < std::min(acknowledged.size(), solution.committed.size()); ++light)
            for (const auto& piece : acknowledged[light].intervals())
                if (!solution.committed[light].covers(piece.begin, piece.end))
                    checks_.violated(name + " ended without particles that were acknowledged");
        if (record.flights_lost && (record.complete || spec.strategy == Strategy::sets))
            checks_.violated(name + " has lost particles in flight");
        if (!record.flights_lost &&
            solution_digest(solution) != solution_digest(reference_solution(spec, solution.committed)))
            checks_.violated(name + " has other bits than one tracer gives");
    }
}

}  // namespace lumenfarm::testing
