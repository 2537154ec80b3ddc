#pragma once

#include "master/commit_queue.h"
#include "master/master_core.h"
#include "master/storage.h"
#include "tests/simulation/fake_tracer.h"
#include "tests/simulation/simulated_disk.h"
#include "tests/simulation/simulated_vfs.h"
#include "tests/simulation/small_scene.h"
#include "worker/worker_core.h"

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <queue>
#include <random>
#include <vector>

/// A whole farm in one thread under a fake clock: the real cores and the real storage, a fake tracer, a network that
/// delays and drops, a disk that loses its power and is full. One seed replays it.
namespace lumenfarm::testing {

struct FarmOptions {
    std::uint64_t seed = 1;
    std::size_t workers = 3;
    std::uint32_t threads = 2;
    double seconds_between_drops = 0;       ///< of connections; 0: never
    double seconds_between_crashes = 0;     ///< of workers, which start again as new processes
    double seconds_between_power_cuts = 0;  ///< of the master; it starts again with what the disk has left
    double seconds_between_full_disks = 0;  ///< for some seconds each
    double disk_failures = 0;               ///< chance that a write or a sync fails; the master starts again
    double checkpoint_seconds = 10;
    bool one_worker_sleeps = false;  ///< is alive, and traces nothing for a very long time
};

class Farm {
public:
    Farm(const JobSpec& spec, const FarmOptions& options);

    /// Runs until the job is over. False when that takes absurdly long.
    bool run();
    void at(double time_s, std::function<void()> event);

    void cancel();
    void drain_worker(std::size_t index);
    const MasterCore& master() const { return *master_; }
    /// As it lies on the master's disk. REQUIRES: the job is over.
    Solution solution();
    /// What must never happen, a sentence each: acknowledged work that is gone, damage where only the power was cut.
    const std::vector<std::string>& violations() const { return violations_; }
    std::uint64_t power_cuts() const { return master_life_ - 1; }
    wire::JobState state() const;
    double now_s() const { return now_s_; }
    std::size_t workers_finished() const { return finished_; }
    std::uint64_t most_results_held() const { return most_results_held_; }

private:
    struct SlotRun {
        std::unique_ptr<TraceSlot> slot;
        SlotAsk interrupt = SlotAsk::nothing;
        bool busy = false;
    };
    struct Node {
        std::unique_ptr<worker::WorkerCore> core;
        std::uint64_t life = 0;  ///< events of an earlier process are dropped
        SessionId session = 0;   ///< 0: not connected
        WorkerId instance = 0;
        double slice_s = 0;
        double last_to_master_s = 0, last_to_worker_s = 0;  ///< TCP keeps the order
        std::vector<SlotRun> slots;
        std::shared_ptr<const SceneContext> scene;
        bool over = false;
    };
    /// A result that a worker has offered.
    struct Offer {
        WorkerId worker;
        std::uint64_t result;
        auto operator<=>(const Offer&) const = default;
    };
    struct Event {
        double time_s;
        std::uint64_t number;
        std::function<void()> run;
        bool operator<(const Event& other) const {
            return std::pair(time_s, number) > std::pair(other.time_s, other.number);
        }
    };

    double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
    double exponential(double mean_s) { return std::exponential_distribution<double>(1 / mean_s)(random_); }

    void start_worker(std::size_t index);
    void connect(std::size_t index);
    void drop(std::size_t index);
    void start_master();
    void begin_life(std::unique_ptr<Storage> storage, Storage::Start start);
    void cut_power();
    void submit();
    void fill_disk();
    void check(const RecoveredJob& recovered);
    void note_answer(WorkerId worker, const wire::ResultAck& ack);
    /// Carries `work` out on the master's storage after what was asked for before, then tells the master.
    template <class Work, class Then>
    void slowly(Work work, Then then);
    void commit(bool leases_too);
    void beat(std::size_t index, std::uint64_t life);
    void repeat(double mean_s, std::function<void()> event);

    void carry_out(Effects effects);
    void carry_out(Send& send);
    void carry_out(Close& close);
    void carry_out(Admit& admit);
    void carry_out(StoreChunk&) {}
    void carry_out(ServeManifest& serve);
    void carry_out(ServeChunk& serve);
    void carry_out(Prepare& prepare);
    void carry_out(StoreResult& store);
    void carry_out(StoreLeases& leases) { commits_.add(leases); }
    void carry_out(StoreSnapshot& store);
    void carry_out(StoreRecord& store);
    void carry_out(StoreSolution& store);
    void carry_out(Discarded&) {}
    void to_worker(SessionId session, wire::Message message);

    void carry_out(std::size_t index, worker::Effects effects);
    void carry_out(std::size_t index, worker::Send& send);
    void carry_out(std::size_t index, worker::StartSlot& start);
    void carry_out(std::size_t index, worker::ContinueSlot& effect);
    void carry_out(std::size_t index, worker::TellSlot& tell);
    void carry_out(std::size_t index, worker::InterruptSlot& interrupt);
    void carry_out(std::size_t index, worker::LoadScene& load);
    void carry_out(std::size_t, worker::KeepScene&) {}
    void carry_out(std::size_t index, worker::PrepareJob& prepare);
    void carry_out(std::size_t index, worker::Finished&);
    void carry_out(std::size_t, worker::GiveUp&);
    void carry_out(std::size_t, worker::Discarded&) {}
    void to_master(std::size_t index, wire::Message message);
    void slice(std::size_t index, std::uint64_t life, std::size_t slot, SlotAsk ask);
    /// An event of this worker process; dropped when the process is gone.
    void later(std::size_t index, double delay_s, std::function<worker::Effects(worker::WorkerCore&)> event);

    JobSpec spec_;
    FarmOptions options_;
    std::mt19937_64 random_;
    std::vector<std::byte> scene_bytes_;
    SimulatedDisk disk_;
    SimulatedVfs vfs_;
    std::unique_ptr<Storage> storage_;
    std::unique_ptr<MasterCore> master_;
    std::uint64_t master_life_ = 0;
    CommitQueue commits_;
    double storage_free_s_ = 0;  ///< when it has done what it was asked for
    bool submitted_ = false;
    std::map<Offer, std::vector<wire::Claim>> offers_;
    std::vector<IntervalSet> acknowledged_;  ///< by light
    std::vector<std::string> violations_;
    std::vector<Node> nodes_;
    std::map<SessionId, std::size_t> sessions_;
    SessionId next_session_ = 1;
    std::uint64_t next_instance_ = 1;
    std::priority_queue<Event> events_;
    std::uint64_t events_made_ = 0;
    double now_s_ = 0;
    std::size_t finished_ = 0;
    std::uint64_t most_results_held_ = 0;
};

/// The result that the job must have: every particle traced once, by nobody's leave.
Solution reference_solution(const JobSpec& spec);

}  // namespace lumenfarm::testing
