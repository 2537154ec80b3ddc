#pragma once

#include "tests/master/master_fixture.h"

#include <optional>
#include <string>

/// A master that people tell what to do with jobs.
namespace lumenfarm::testing {

class ControlTest : public MasterTest {
protected:
    void control(JobId job, wire::JobAction action, std::uint64_t particles = 0) {
        take(master_.on_message(embedding_session, wire::ControlRequest(job, action, particles), 9, now_s_));
    }
    std::optional<wire::JobState> answered() const {
        const auto reply = sent<wire::ControlReply>(embedding_session);
        return reply ? std::optional(reply->state) : std::nullopt;
    }
    std::string refused() const {
        const auto refusal = sent<wire::Refusal>(embedding_session);
        return refusal ? refusal->sentence : "";
    }
    wire::JobState state(JobId job) const { return master_.status(job, now_s_)->state; }
    std::string why(JobId job) const { return master_.status(job, now_s_)->sentence; }
    void put_aside() {
        const auto aside = find<PutAside>();
        ASSERT_TRUE(aside);
        take(master_.on_put_aside(*aside, now_s_));
    }
    /// Traces everything that a job has.
    void trace_all() {
        for (auto leases = pull(ann, 1); !leases.empty(); leases = pull(ann, 1))
            ASSERT_EQ(deliver(ann, trace(leases[0], ++results_)), wire::Verdict::accepted);
    }
    void finish(JobId) {
        trace_all();
        store_solution();
    }
    RecoveredJob half_done() {
        RecoveredJob half;
        half.committed.resize(prepared_->particles.size());
        for (std::size_t light = 0; light < prepared_->particles.size(); ++light)
            half.committed[light].insert(0, prepared_->particles[light] / 2);
        return half;
    }
    std::uint64_t results_ = 0;
};

}  // namespace lumenfarm::testing
