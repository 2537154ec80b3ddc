#include "tests/simulation/simulated_client.h"

#include "common/scene/scene_file.h"
#include "common/support/limits.h"
#include "tests/simulation/small_scene.h"

#include <algorithm>
#include <utility>

namespace lumenfarm::testing {

namespace {

constexpr double between_questions_s = 3;
constexpr double after_refusal_s = 1;

}  // namespace

SimulatedClient::SimulatedClient(World& world, std::size_t index, std::uint64_t instance, const ClientPlan& plan)
    : world_(world),
      index_(index),
      instance_(instance),
      plan_(plan),
      scene_bytes_(encode_scene(small_scene())),
      manifest_(scene_digest(scene_bytes_), scene_bytes_.size(), chunk_digests(scene_bytes_)) {
    world_.clock.at(plan.submit_s, [this] { connect(); });
}

void SimulatedClient::connect() {
    if (content_ || connection_ != 0) return;
    if (!asks_since_s_) asks_since_s_ = world_.now_s();
    connection_ = world_.network.connect(host(), *this);
}

void SimulatedClient::on_open(ConnectionId) {
    wire::Hello hello(wire::Role::submitter, "client " + std::to_string(index_), instance_);
    world_.network.send(connection_, Side::peer, std::move(hello));
}

void SimulatedClient::on_close(ConnectionId, const std::optional<wire::Goodbye>&) {
    connection_ = 0;
    welcome_ = false;
    waiting_ = 0;
    world_.clock.after(world_.chance.uniform(limits::reconnect_seconds_min, between_questions_s),
                       [this] { connect(); });
}

std::optional<wire::Message> SimulatedClient::question() const {
    if (job_ == 0) return wire::Submit(instance_, plan_.spec, manifest_);
    if (found_paused_) return wire::ControlRequest(job_, wire::JobAction::resume);
    if (!wishes_.empty() && world_.now_s() >= wishes_.front().time_s) return wishes_.front().request;
    return wire::StatusRequest(job_);
}

void SimulatedClient::ask() {
    if (!welcome_ || waiting_ != 0 || content_) return;
    if (!asks_since_s_) asks_since_s_ = world_.now_s();
    waiting_ = ++asked_;
    world_.network.send(connection_, Side::peer, *question(), waiting_);
    world_.clock.after(limits::reply_seconds, [this, request = waiting_] { give_up(request); });
}

/// The connection is there, and no answer comes.
void SimulatedClient::give_up(std::uint64_t request) {
    if (waiting_ != request) return;
    world_.note(Who::client, index_, "waits no longer for the answer to its question", {request});
    world_.network.close(connection_, Side::peer, wire::Goodbye(wire::GoodbyeReason::done));
    on_close(connection_, std::nullopt);
}

void SimulatedClient::pause(double seconds) {
    world_.clock.after(seconds, [this] { ask(); });
}

void SimulatedClient::on_message(ConnectionId, wire::Message message, std::uint64_t request_id) {
    if (std::holds_alternative<wire::Welcome>(message)) {
        welcome_ = true;
        return ask();
    }
    if (waiting_ == 0 || request_id != waiting_) return;
    waiting_ = 0;
    if (const auto* refusal = std::get_if<wire::Refusal>(&message)) {
        // what can't be done to a job that has ended is not asked for again
        const bool hopeless = refusal->reason == wire::RefusalReason::bad_request && job_ != 0;
        if (hopeless && !std::exchange(found_paused_, false)) wishes_.erase(wishes_.begin());
        return pause(after_refusal_s);
    }
    if (const auto* submitted = std::get_if<wire::SubmitReply>(&message)) return take(*submitted);
    if (const auto* status = std::get_if<wire::StatusReply>(&message)) return take(*status);
    asks_since_s_.reset();
    if (std::holds_alternative<wire::ControlReply>(message) && !std::exchange(found_paused_, false)) {
        particles_ = std::max(particles_, wishes_.front().request.particles);
        wishes_.erase(wishes_.begin());
    }
    ask();
}

void SimulatedClient::take(const wire::SubmitReply& reply) {
    for (const std::uint32_t index : reply.missing) {
        const std::size_t begin = index * limits::chunk_bytes;
        const std::size_t end = std::min(begin + limits::chunk_bytes, scene_bytes_.size());
        std::vector<std::byte> bytes(scene_bytes_.data() + begin, scene_bytes_.data() + end);
        world_.network.send(connection_, Side::peer, wire::Chunk(manifest_.file, index, std::move(bytes)));
    }
    if (reply.job == 0) return ask();
    asks_since_s_.reset();
    world_.note(Who::client, index_, "has a job", {reply.job});
    job_ = reply.job;
    particles_ = plan_.spec.particles;
    const auto wish = [&](std::optional<double> after_s, wire::JobAction action, std::uint64_t particles = 0) {
        if (after_s) wishes_.push_back({world_.now_s() + *after_s, wire::ControlRequest(job_, action, particles)});
    };
    wish(plan_.cancel_after_s, wire::JobAction::cancel);
    wish(plan_.pause_after_s, wire::JobAction::pause);
    wish(plan_.extend_after_s, wire::JobAction::extend, plan_.extended_particles);
    std::sort(wishes_.begin(), wishes_.end(), [](const Wish& a, const Wish& b) { return a.time_s < b.time_s; });
    ask();
}

void SimulatedClient::take(const wire::StatusReply& reply) {
    asks_since_s_.reset();
    const wire::JobState state = reply.jobs.front().state;
    found_paused_ = state == wire::JobState::paused;
    if (!wire::is_over(state) || !wishes_.empty()) return pause(between_questions_s);
    world_.note(Who::client, index_, "hears that its job is over", {job_, static_cast<std::uint64_t>(state)});
    content_ = true;
    world_.network.close(connection_, Side::peer, wire::Goodbye(wire::GoodbyeReason::done));
}

}  // namespace lumenfarm::testing
