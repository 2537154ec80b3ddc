#include "master/snapshot_file.h"
#include "tests/simulation/simulated_disk.h"
#include "tests/simulation/small_job.h"

#include <gtest/gtest.h>

/// What a job has learned of its cuts, and what a next life of the master knows of it.
namespace lumenfarm::testing {
namespace {

TEST(CutLessons, LastWithTheSnapshotOfTheNewCut) {
    SmallJob job(Strategy::subspaces);
    job.record.spec.subspaces = 6;
    job.prepared = prepare_job(job.record.spec, job.scene).value();
    const Subspaces& planned = *job.prepared->subspaces;
    const auto count = static_cast<std::uint32_t>(planned.all().size());
    SimulatedDisk disk;
    ASSERT_TRUE(disk.make_folder("/segments"));
    FileStore files(disk, "/files");
    ASSERT_TRUE(files.open());
    JobLog log(disk, "/segments", {}, job.record, job.prepared);
    ASSERT_TRUE(log.recover({}, files));
    LearnedCut learned;
    learned.cut = Subspaces::cut(planned.root(), {{planned.root(), 1}}, count).partition();
    learned.lesson = CutLesson{planned.partition(), std::vector<double>(count, 2)};
    ASSERT_NE(learned.cut, planned.partition());
    log.cut_by(learned);

    const std::vector<std::byte> bytes = log.snapshot_bytes({});
    const auto snapshot = decode_snapshot(bytes, *job.prepared, job.record.status.scene);
    ASSERT_TRUE(snapshot) << snapshot.error().sentence;
    EXPECT_EQ(snapshot->cut, learned.cut);
    EXPECT_EQ(snapshot->work_times.lessons, std::vector{*learned.lesson});

    JobStore::Unfinished kept;
    kept.snapshot = Snapshot{files.put(bytes).value(), 0};
    JobLog next(disk, "/segments", {}, job.record, job.prepared);
    const auto damages = next.recover(kept, files);
    ASSERT_TRUE(damages) << damages.error().sentence;
    EXPECT_TRUE(damages->empty());
    EXPECT_EQ(next.cut(), learned.cut);
    EXPECT_EQ(next.sums().work_times(), log.sums().work_times());
}

}  // namespace
}  // namespace lumenfarm::testing
