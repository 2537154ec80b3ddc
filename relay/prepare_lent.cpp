#include "relay/prepare_lent.h"

#include <limits>
#include <utility>

namespace lumenfarm::relay {

namespace {

/// What is not lent counts as committed.
RecoveredJob nothing_lent(std::shared_ptr<const PreparedJob> prepared, WorkerFiles files) {
    RecoveredJob job;
    job.committed.resize(prepared->sources());
    for (std::size_t light = 0; light < prepared->particles.size(); ++light)
        job.committed[light].insert(0, prepared->particles[light]);
    job.flights = FlightQueues(prepared->sources() - prepared->particles.size());
    job.keep_threshold = std::numeric_limits<std::uint64_t>::max();
    job.files = std::move(files);
    job.prepared = std::move(prepared);
    return job;
}

}  // namespace

Result<Preparation> prepare_lent(const PrepareLent& effect, const ReadFile& read) {
    const wire::JobInfo& info = effect.info;
    WorkerFiles files{info.scene, info.scene_bytes, {}};
    Digest scene = info.scene;
    if (info.spec.strategy == Strategy::subspaces) {
        const auto bytes = read(info.scene);
        if (!bytes) return bytes.error();
        auto plan = decode_plan(*bytes);
        if (!plan) return plan.error();
        if (!effect.whole_is_here) return Preparation(PlanRead{plan->whole, std::move(plan->parts)});
        scene = plan->whole.file;
        files.parts = std::move(plan->parts);
    }
    const auto bytes = read(scene);
    if (!bytes) return bytes.error();
    auto prepared = prepare_job(info.spec, *bytes);
    if (!prepared) return prepared.error();
    const std::size_t subspaces = (*prepared)->sources() - (*prepared)->particles.size();
    if (subspaces != files.parts.size())
        return bad_input("the plan is of " + std::to_string(files.parts.size()) + " subspaces, the job of " +
                         std::to_string(subspaces));
    return Preparation(ReadyJob{nothing_lent(std::move(*prepared), std::move(files))});
}

}  // namespace lumenfarm::relay
