#pragma once

#include "master/disk/file_store.h"
#include "master/disk/storage_lock.h"
#include "master/peer_session.h"
#include "relay/relay_core.h"
#include "relay/relay_server.h"
#include "worker/master_session.h"

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace lumenfarm {

/// The shell of RelayCore: one thread for all connections and the core, one for files and what is derived from them.
class RelayServer::Running : public PeerEvents, public MasterEvents {
public:
    Running(const RelayOptions& options, const net::HostPort& upstream, const relay::RelayIdentity& identity,
            const MasterPolicy& farm, StorageLock lock, std::unique_ptr<Disk> disk, std::unique_ptr<FileStore> files);
    ~Running() override;

    Result<void> listen(const std::string& where, bool allow_plaintext) {
        return peers_.listen(where, allow_plaintext);
    }
    void run();
    const std::string& address() const { return peers_.address(); }
    void drain();
    void end_now();
    bool ended() const;
    Result<void> wait();
    std::uint64_t particles_merged() const { return merged_; }
    std::vector<ServingThread> threads();
    std::string summary() const;

    void on_peer(SessionId session, const std::string& address) override;
    void on_peer_message(SessionId session, wire::Message message, std::uint64_t request_id) override;
    void on_peer_gone(SessionId session) override;
    void on_peer_closed(const net::Closed& closed) override;
    void on_accept_failed(const std::string& why) override;
    void on_master_open() override;
    void on_master_message(wire::Message message) override;
    void on_master_lost(const net::Closed& closed) override;
    void on_master_finished(const std::optional<net::Closed>& closed) override;
    std::optional<wire::Message> next_bulk() override { return core_.next_bulk(); }

private:
    double now_s() const;
    void tick();
    void end(std::optional<Error> error);
    void stop_if_done();

    void carry_out(relay::Effects effects);
    void carry_out(const relay::SendUp& send) { master_.send(send.message); }
    void carry_out(const Send& send) { peers_.carry_out(send); }
    void carry_out(const Close& close) { peers_.carry_out(close); }
    template <class Serve, class Request>
    void serve(const Serve& effect, Request request);
    void carry_out(const ServeManifest& effect) { serve(effect, wire::ManifestRequest(effect.file)); }
    void carry_out(const ServeChunk& effect) { serve(effect, wire::ChunkRequest(effect.file, effect.index)); }
    void carry_out(const relay::KeepFile& keep);
    void carry_out(const relay::RemoveFile& remove);
    void carry_out(const relay::PrepareLent& prepare);
    void carry_out(const relay::Finished&) { end(std::nullopt); }
    void carry_out(const relay::GiveUp& give_up) { end(failed(give_up.sentence)); }
    void carry_out(const Discarded& discarded);
    void carry_out(const worker::Discarded& discarded);
    /// Runs `work` on the files' thread and then `then(result)` here.
    template <class Work, class Then>
    void slowly(Work work, Then then);

    boost::asio::io_context io_{1};
    boost::asio::executor_work_guard<boost::asio::io_context::executor_type> busy_{io_.get_executor()};
    boost::asio::thread_pool files_thread_{1};
    boost::asio::steady_timer timer_{io_};
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();

    StorageLock lock_;
    std::unique_ptr<Disk> disk_;
    std::unique_ptr<FileStore> files_;  ///< the files' thread only
    relay::RelayCore core_;
    PeerSessions peers_{io_, *this};
    MasterSession master_;

    std::atomic<std::uint64_t> merged_ = 0;
    std::optional<double> end_by_s_;  ///< ending: for the goodbyes to leave; the loop's thread only
    bool left_master_ = false;        ///< ending: its Goodbye has left
    mutable std::mutex mutex_;        ///< for the following
    std::condition_variable ended_changed_;
    bool ended_ = false;
    std::optional<Error> error_;
    std::string summary_;
    std::thread thread_;
};

}  // namespace lumenfarm
