#include "common/solution/solution_file.h"
#include "common/support/file.h"
#include "master/master_server.h"
#include "tests/simulation/small_scene.h"
#include "worker/worker_client.h"

#include <gtest/gtest.h>

#include <filesystem>

/// Master and workers as they are embedded: real sockets, threads, files and tracer.
namespace lumenfarm::testing {
namespace {

namespace fs = std::filesystem;

constexpr double patience_s = 120;

class EmbeddedFarm : public ::testing::Test {
protected:
    EmbeddedFarm() {
        folder_ = fs::path(::testing::TempDir()) /
                  (std::string("farm_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
        fs::remove_all(folder_);
    }
    ~EmbeddedFarm() override { fs::remove_all(folder_); }

    std::unique_ptr<MasterServer> start_master() const {
        MasterOptions options;
        options.listen = "127.0.0.1:0";
        options.storage = folder_ / "storage";
        auto master = MasterServer::start(options);
        EXPECT_TRUE(master) << master.error().sentence;
        return std::move(*master);
    }
    std::unique_ptr<WorkerClient> start_worker(const MasterServer& master, std::uint32_t threads) const {
        WorkerOptions options;
        options.master = master.address();
        options.threads = threads;
        options.cache = folder_ / "cache";
        auto worker = WorkerClient::start(options);
        EXPECT_TRUE(worker) << worker.error().sentence;
        return std::move(*worker);
    }
    static JobSpec job(Packing packing) {
        JobSpec spec;
        spec.particles = 300'000;
        spec.packing = packing;
        spec.keep_hits = 1'000;
        return spec;
    }
    fs::path folder_;
    std::vector<std::byte> scene_ = encode_scene(small_scene());
};

TEST_F(EmbeddedFarm, WorkersThreadsAndPackingsGiveOneDigest) {
    auto master = start_master();
    std::vector<std::unique_ptr<WorkerClient>> workers;
    std::optional<Digest> digest;
    for (const Packing packing : {Packing::records, Packing::maps}) {
        workers.push_back(start_worker(*master, static_cast<std::uint32_t>(1 + workers.size())));
        const auto id = master->submit(job(packing), scene_);
        ASSERT_TRUE(id) << id.error().sentence;
        const auto status = master->wait(*id, patience_s);
        ASSERT_TRUE(status);
        ASSERT_EQ(status->state, wire::JobState::done) << status->sentence;
        EXPECT_EQ(status->committed, 300'000u);
        EXPECT_EQ(status->results_invalid, 0u);
        if (!digest) digest = status->digest;
        EXPECT_EQ(status->digest, digest);
        const auto files = master->files(*id);
        ASSERT_TRUE(files);
        const auto solution =
            decode_solution(*read_file(files->solution, 1u << 30), small_scene(), scene_digest(scene_));
        ASSERT_TRUE(solution) << solution.error().sentence;
        EXPECT_EQ(solution_digest(*solution), *digest);
    }
    for (auto& worker : workers) {
        worker->drain();
        EXPECT_TRUE(worker->wait());
    }
}

TEST_F(EmbeddedFarm, CancelledJobLeavesAValidPartialSolution) {
    auto master = start_master();
    const auto worker = start_worker(*master, 1);
    JobSpec spec = job(Packing::automatic);
    spec.particles = 4'000'000'000;
    const auto id = master->submit(spec, scene_);
    ASSERT_TRUE(id);
    for (int i = 0; i < 600 && master->status(*id)->committed == 0; ++i) master->wait(*id, 0.1);
    master->cancel(*id);
    const auto status = master->wait(*id, patience_s);
    ASSERT_EQ(status->state, wire::JobState::cancelled);
    const auto files = master->files(*id);
    ASSERT_TRUE(files) << files.error().sentence;
    EXPECT_FALSE(files->complete);
    const auto solution = decode_solution(*read_file(files->solution, 1u << 30), small_scene(), scene_digest(scene_));
    ASSERT_TRUE(solution) << solution.error().sentence;
    EXPECT_GT(solution->balance.particles, 0u);
    EXPECT_TRUE(solution->balance.closed());
}

TEST_F(EmbeddedFarm, FinishedJobsOutliveTheMasterAndUnfinishedOnesGoOn) {
    JobId done = 0, unfinished = 0;
    std::optional<Digest> digest;
    {
        auto master = start_master();
        auto worker = start_worker(*master, 1);
        done = *master->submit(job(Packing::records), scene_);
        digest = master->wait(done, patience_s)->digest;
        worker.reset();
        unfinished = *master->submit(job(Packing::records), scene_);
    }
    auto master = start_master();
    EXPECT_EQ(master->status(done)->state, wire::JobState::done);
    EXPECT_TRUE(master->files(done));
    const auto worker = start_worker(*master, 1);
    const auto status = master->wait(unfinished, patience_s);
    ASSERT_EQ(status->state, wire::JobState::done);
    EXPECT_EQ(status->digest, digest) << "the same job";
}

TEST_F(EmbeddedFarm, BadStartsAreSentences) {
    const auto master = start_master();
    MasterOptions options;
    options.listen = master->address();
    options.storage = folder_ / "other";
    const auto busy = MasterServer::start(options);
    ASSERT_FALSE(busy);
    EXPECT_EQ(busy.error().code, ErrorCode::failed);
    EXPECT_NE(busy.error().sentence.find(std::to_string(master->port())), std::string::npos);
    options.listen = "127.0.0.1:0";
    options.storage = folder_ / "storage";
    EXPECT_FALSE(MasterServer::start(options)) << "two masters on one storage";
    options.storage = folder_ / "third";
    options.listen = "0.0.0.0:0";
    const auto open_to_all = MasterServer::start(options);
    ASSERT_FALSE(open_to_all);
    EXPECT_EQ(open_to_all.error().code, ErrorCode::bad_input);
    EXPECT_NE(open_to_all.error().sentence.find("--allow-plaintext"), std::string::npos);
    const auto no_scene = master->submit(job(Packing::records), std::vector<std::byte>(100));
    ASSERT_FALSE(no_scene);
    EXPECT_EQ(no_scene.error().code, ErrorCode::bad_input);
}

}  // namespace
}  // namespace lumenfarm::testing
