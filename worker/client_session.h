#pragma once

#include "worker/master_session.h"
#include "worker/scene_cache.h"
#include "worker/slot_thread.h"
#include "worker/worker_client.h"
#include "worker/worker_core.h"

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace lumenfarm {

/// The shell of WorkerCore: a thread for the connection and the core, one for scenes, one for each slot.
class WorkerClient::Running : public MasterEvents {
public:
    Running(const WorkerOptions& options, const net::HostPort& master, const worker::WorkerIdentity& identity);
    ~Running() override;

    void drain();
    void end_now();
    Result<void> wait();
    bool ended() const;
    std::vector<ServingThread> threads();
    std::string summary() const;
    bool connected() const { return master_.welcome(); }
    std::uint64_t particles_merged() const { return merged_; }

    void on_master_open() override;
    void on_master_message(wire::Message message) override;
    void on_master_lost(const net::Closed& closed) override;
    void on_master_finished(const std::optional<net::Closed>& closed) override;
    std::optional<wire::Message> next_bulk() override { return core_.next_bulk(); }

private:
    double now_s() const;
    void tick();
    void end(std::optional<Error> error);

    void carry_out(worker::Effects effects);
    void carry_out(const worker::Send& send);
    void carry_out(const worker::StartSlot& effect) { slots_[effect.slot]->start(effect.work); }
    void carry_out(const worker::ContinueSlot& effect) { slots_[effect.slot]->resume(); }
    void carry_out(const worker::TellSlot& effect) { slots_[effect.slot]->tell(effect.ask); }
    void carry_out(const worker::InterruptSlot& effect) { slots_[effect.slot]->interrupt(effect.ask); }
    void carry_out(const worker::LoadScene& load);
    void carry_out(const worker::KeepScene& keep);
    void carry_out(const worker::PrepareJob& prepare);
    void carry_out(const worker::PreparePart& prepare);
    void carry_out(const worker::Finished&);
    void carry_out(const worker::GiveUp& give_up);
    void carry_out(const worker::Discarded& discarded);
    void discard(worker::Discard reason, std::string sentence);

    std::string isa_;
    JobMaker make_job_;  ///< scenes' thread only
    boost::asio::io_context io_{1};
    boost::asio::executor_work_guard<boost::asio::io_context::executor_type> busy_{io_.get_executor()};
    boost::asio::thread_pool scene_thread_{1};
    boost::asio::steady_timer tick_timer_{io_};
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();

    worker::SceneCache cache_;
    worker::WorkerCore core_;
    MasterSession master_;

    std::atomic<std::uint64_t> merged_ = 0;
    bool ending_ = false;       ///< the loop's thread only
    mutable std::mutex mutex_;  ///< for the following
    std::condition_variable ended_changed_;
    bool ended_ = false;
    std::optional<Error> error_;
    std::string summary_;
    std::vector<std::unique_ptr<worker::Slot>> slots_;
    std::thread thread_;
};

}  // namespace lumenfarm
