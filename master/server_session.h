#pragma once

#include "common/service/pulse.h"
#include "master/disk/storage_lock.h"
#include "master/master_core.h"
#include "master/master_server.h"
#include "master/peer_session.h"
#include "master/storage.h"

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace lumenfarm {

/// The shell of MasterCore: one thread for all connections and the core, one for the storage.
class MasterServer::Running : public PeerEvents {
public:
    Running(const MasterPolicy& policy, StorageLock lock, std::unique_ptr<Disk> disk, std::unique_ptr<Storage> storage);
    ~Running() override;

    Result<void> listen(const std::string& where, bool allow_plaintext) {
        return peers_.listen(where, allow_plaintext);
    }
    /// Takes the records over and starts the threads.
    /// `damages`: records that had to be left out.
    void run(std::vector<JobRecord> records, const std::vector<std::string>& damages);
    void stop();
    std::vector<ServingThread> threads();
    std::string summary() const;

    /// Runs `task` on the master's thread and gives what it returns. REQUIRES: not stopped (then: nothing).
    template <class Task>
    auto ask(Task task) -> std::optional<decltype(task())>;
    MasterCore& core() { return core_; }
    double now_s() const;
    void carry_out(Effects effects);
    std::uint16_t port() const { return peers_.port(); }
    const std::string& address() const { return peers_.address(); }
    FileStore& files() { return storage_->files(); }
    /// Why the master can't go on, once that is so: it answers nobody any more and is to be stopped.
    std::optional<Error> failure() const;

    Result<JobId> submit(const JobSpec& spec, std::span<const std::byte> scene_bytes);
    /// Waits until something may have changed, at most `seconds`.
    void wait_for_change(double seconds);

    void on_peer(SessionId session, const std::string& address) override;
    void on_peer_message(SessionId session, wire::Message message, std::uint64_t request_id) override;
    void on_peer_gone(SessionId session) override;
    void on_peer_closed(const net::Closed& closed) override;
    void on_accept_failed(const std::string& why) override;

private:
    void carry_out(Send send);
    void carry_out(Close close) { peers_.carry_out(close); }
    void carry_out(Admit admit);
    void carry_out(StoreChunk store);
    template <class Serve>
    void serve(Serve effect);
    void carry_out(ServeManifest effect) { serve(effect); }
    void carry_out(ServeChunk effect) { serve(effect); }
    void carry_out(Prepare prepare);
    void carry_out(MeasureCut measure);
    void carry_out(StoreResult store);
    void carry_out(StoreLeases leases) { commits_.add(leases); }
    void carry_out(StoreSnapshot store);
    void carry_out(StoreRecord store);
    void carry_out(Retract retract);
    void carry_out(PutAside aside);
    void carry_out(RemoveJob remove);
    void carry_out(StoreSolution store);
    void carry_out(const Discarded& discarded);
    void discard(Discard reason, const std::string& sentence);
    void commit(bool leases_too);

    /// Runs `work` on the storage's thread and then `then(result)` here, unless the disk is broken.
    template <class Work, class Then>
    void slowly(Work work, Then then);
    void tick();
    void end_if_done();
    void fail(const Error& error);

    boost::asio::io_context io_{1};
    boost::asio::executor_work_guard<boost::asio::io_context::executor_type> busy_{io_.get_executor()};
    boost::asio::thread_pool storage_thread_{1};
    boost::asio::steady_timer timer_{io_};
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();

    StorageLock lock_;
    std::unique_ptr<Disk> disk_;
    std::unique_ptr<Storage> storage_;
    CommitQueue commits_;
    MasterCore core_;
    PeerSessions peers_{io_, *this};
    SessionId asking_ = 0;                                          ///< whose message is being handled
    std::map<std::uint64_t, std::promise<wire::Message>> replies_;  ///< to the embedding program
    std::uint64_t next_request_ = 1;

    mutable std::mutex changed_mutex_;
    std::optional<Error> failure_;
    std::condition_variable changed_;
    std::uint64_t changes_ = 0;
    std::string summary_;
    bool stopping_ = false;
    std::size_t slow_works_ = 0;      ///< that the storage has not finished
    std::optional<double> end_by_s_;  ///< for the goodbyes to leave, once they are said
    std::thread thread_;
};

}  // namespace lumenfarm
