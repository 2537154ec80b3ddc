#pragma once

#include "common/scene/job_spec.h"
#include "tests/simulation/world.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

/// Somebody with a job: submits it, perhaps pauses, extends or cancels it, asks how it goes until it is over. Asks
/// again, with the same key, whenever a connection or an answer is lost.
namespace lumenfarm::testing {

struct ClientPlan {
    explicit ClientPlan(JobSpec spec_ = {}) : spec(std::move(spec_)) {}
    JobSpec spec;
    double submit_s = 0;
    // after the master has taken the job
    std::optional<double> cancel_after_s;
    std::optional<double> pause_after_s;  ///< it is resumed when it is found paused
    std::optional<double> extend_after_s;
    std::uint64_t extended_particles = 0;
};

class SimulatedClient : public NetworkEnd {
public:
    /// `instance` is its key, too.
    SimulatedClient(World& world, std::size_t index, std::uint64_t instance, const ClientPlan& plan);

    HostId host() const { return host_of_client(index_); }
    std::uint64_t instance() const { return instance_; }
    const ClientPlan& plan() const { return plan_; }
    std::uint64_t job() const { return job_; }  ///< 0: not answered yet
    /// That its job has at least, as the master has told it.
    std::uint64_t particles() const { return particles_; }
    /// It was told that its job is over, and has no more questions.
    bool content() const { return content_; }
    /// Since when it waits for an answer; nothing while it does not.
    std::optional<double> asks_since_s() const { return asks_since_s_; }

    void on_open(ConnectionId connection) override;
    void on_message(ConnectionId connection, wire::Message message, std::uint64_t request_id) override;
    void on_close(ConnectionId connection, const std::optional<wire::Goodbye>& goodbye) override;

private:
    void connect();
    /// What it wants to know next.
    std::optional<wire::Message> question() const;
    void ask();
    void give_up(std::uint64_t request);
    void take(const wire::SubmitReply& reply);
    void take(const wire::StatusReply& reply);
    void pause(double seconds);

    World& world_;
    std::size_t index_;
    std::uint64_t instance_;
    ClientPlan plan_;
    std::vector<std::byte> scene_bytes_;
    wire::FileManifest manifest_;
    ConnectionId connection_ = 0;
    bool welcome_ = false;
    std::uint64_t asked_ = 0;    ///< requests so far; the id of the last one
    std::uint64_t waiting_ = 0;  ///< id of the request that has no answer yet
    std::optional<double> asks_since_s_;
    std::uint64_t job_ = 0;
    struct Wish {
        double time_s = 0;
        wire::ControlRequest request;
    };
    std::vector<Wish> wishes_;  ///< by time
    bool found_paused_ = false;
    std::uint64_t particles_ = 0;
    bool content_ = false;
};

}  // namespace lumenfarm::testing
