#include "tests/scenes/planned_scene.h"
#include "tests/worker/worker_fixture.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

/// What a worker of the object-space strategy brings in, and what goes for it.
namespace lumenfarm::worker {
namespace {

class WorkerInSubspaces : public WorkerTest {
protected:
    /// Memory for the plans of two jobs, and beside them for one scene as a whole.
    void have_little_memory() {
        WorkerIdentity little = identity();
        little.memory_bytes = limits::worker_bytes + limits::result_bytes_in_flight +
                              2 * little.threads * limits::result_close_bytes +
                              2 * limits::plan_bytes_factor * plan_bytes_.size() + limits::part_bytes +
                              limits::part_bytes_per_triangle * planned_.scene.triangles.size();
        core_ = WorkerCore(little);
    }
    wire::JobInfo info_of(JobId job) const {
        JobSpec spec;
        spec.strategy = Strategy::subspaces;
        spec.packing = Packing::records;
        return {job, sha256(plan_bytes_), plan_bytes_.size(), spec, 0.1, 2};
    }
    void open(JobId job) {
        hear(info_of(job));
        take(core_.on_scene_loaded(sha256(plan_bytes_), std::make_shared<const std::vector<std::byte>>(plan_bytes_),
                                   now_s_));
        ASSERT_TRUE(find<PrepareJob>());
        const auto context = make_job_context(info_of(job), nullptr, plan_).value();
        take(core_.on_job_prepared(info_of(job), context, now_s_));
    }
    /// The worker gets the file that it has just asked for, and the piece made of it. Gives what it was.
    PartKey bring(bool can_be_made = true) {
        const auto load = find<LoadScene>();
        EXPECT_TRUE(load);
        take(core_.on_scene_loaded(load->scene, nothing_, now_s_));
        const auto prepare = find<PreparePart>();
        EXPECT_TRUE(prepare);
        Result<Piece> piece = failed("no memory");
        if (can_be_made) piece = Piece();
        take(core_.on_part_prepared(prepare->key, prepare->file, std::move(piece), now_s_));
        return prepare->key;
    }
    wire::Lease lease_in_subspace(std::uint64_t number, JobId job) const {
        wire::Lease lease(number, 1, job, {static_cast<std::uint32_t>(planned_.scene.lights.size()), 0, 1}, 0);
        Flight flight;
        flight.direction = {0, 1, 0};
        flight.energy = flight.start_energy = 1;
        lease.flights.push_back(wire::pack_flight(flight, 0));
        return lease;
    }

    testing::PlannedScene planned_{8};
    std::vector<std::byte> plan_bytes_ = encode_plan(planned_.plan);
    std::shared_ptr<const PlanContext> plan_ = make_plan_context(plan_bytes_).value();
    std::shared_ptr<const std::vector<std::byte>> nothing_ = std::make_shared<const std::vector<std::byte>>();
};

TEST_F(WorkerInSubspaces, SceneThatFitsIsBroughtInWholeAndPreparedOnce) {
    welcome();
    open(1);
    hear(lease(1));
    ASSERT_TRUE(core_.summary().find("waits") != std::string::npos) << "for the scene";
    open(2);
    take(core_.on_scene_loaded(planned_.plan.whole.file, nothing_, now_s_));
    EXPECT_EQ(all<PreparePart>().size(), 1u);
    take(core_.on_scene_loaded(planned_.plan.whole.file, nothing_, now_s_));
    EXPECT_TRUE(all<PreparePart>().empty()) << "a job of the other strategy loaded the same file";
    take(core_.on_part_prepared({1, none}, planned_.plan.whole.file, Piece(), now_s_));
    ASSERT_TRUE(sent<wire::PartsHeld>());
    EXPECT_EQ(sent<wire::PartsHeld>()->subspaces.size(), 8u);
    EXPECT_EQ(bring(), (PartKey{2, none}));
    EXPECT_EQ(all<StartSlot>().size(), 1u) << "now that nothing is on its way";
}

TEST_F(WorkerInSubspaces, SceneThatCannotBeMadeWholeComesInParts) {
    welcome();
    open(1);
    EXPECT_TRUE(bring(false).is_whole());
    EXPECT_FALSE(bring().is_whole());
    ASSERT_TRUE(sent<wire::PartsHeld>());
    EXPECT_EQ(sent<wire::PartsHeld>()->subspaces.size(), 1u);
    hear(lease(1));
    EXPECT_FALSE(sent<wire::ReturnLeases>()) << "it does the job all the same";
}

TEST_F(WorkerInSubspaces, SetsThatWaitGoBackWithTheWholeSceneThatTheyWereMadeFor) {
    have_little_memory();
    welcome();
    open(1);
    hear(lease(1));
    hear(lease(2));
    take(core_.on_scene_loaded(planned_.plan.whole.file, nothing_, now_s_));
    take(core_.on_part_prepared({1, none}, planned_.plan.whole.file, Piece(), now_s_));
    EXPECT_EQ(all<StartSlot>().size(), 2u);
    open(2);
    hear(lease_in_subspace(3, 2));
    hear(lease(4));
    finish_set(0, lease(1));
    EXPECT_TRUE(all<StartSlot>().empty()) << "no set begins until the other has its subspace";
    EXPECT_FALSE(find<LoadScene>()) << "a slot is at work in the scene";
    finish_set(1, lease(2));
    EXPECT_EQ(discarded(Discard::part_given_up), 1u);
    ASSERT_TRUE(sent<wire::ReturnLeases>());
    EXPECT_EQ(sent<wire::ReturnLeases>()->leases, std::vector<wire::LeaseRef>(1, wire::LeaseRef(4, 1)));
    EXPECT_EQ(bring(), (PartKey{2, 0}));
    EXPECT_EQ(all<StartSlot>().size(), 1u);
}

}  // namespace
}  // namespace lumenfarm::worker
