#include "cli/embedded_farm.h"

#include <chrono>
#include <utility>

namespace lumenfarm {
namespace {

constexpr double pace_seconds = 1;  // of sets and results: loopback is fast, and somebody watches the progress

}  // namespace

Result<std::unique_ptr<EmbeddedFarm>> EmbeddedFarm::start(const Options& options, const TemporaryFolder& storage) {
    std::unique_ptr<EmbeddedFarm> farm(new EmbeddedFarm);
    MasterOptions master;
    master.listen = "127.0.0.1:0";
    master.storage = storage.path() / "master";
    master.isa = options.isa;
    master.set_target_seconds = pace_seconds;
    master.flush_seconds = pace_seconds;
    auto started = MasterServer::start(master);
    if (!started) return started.error();
    farm->master_ = std::move(*started);
    for (std::uint32_t number = 1; number <= options.workers; ++number) {
        WorkerOptions worker;
        worker.master = farm->master_->address();
        worker.threads = options.threads;
        worker.cache = storage.path() / ("worker-" + std::to_string(number));
        worker.name = "local-" + std::to_string(number);
        worker.isa = options.isa;
        worker.memory_limit_bytes = options.memory_limit_bytes;
        worker.parts_only = options.parts_only;
        worker.idle_priority = false;  // somebody waits for this
        if (auto hired = farm->hire(worker); !hired) return hired.error();
    }
    return farm;
}

EmbeddedFarm::~EmbeddedFarm() {
    for (auto& hand : hands_) hand.worker->drain();
    for (auto& hand : hands_) hand.ended.wait();
    hands_.clear();
    if (master_) master_->stop();
}

Result<void> EmbeddedFarm::check_workers() {
    for (auto& hand : hands_)
        if (hand.ended.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return {};
    for (auto& hand : hands_)
        if (const auto& ended = hand.ended.get(); !ended) return ended;
    return failed("the workers ended before the job");
}

Result<void> EmbeddedFarm::hire(const WorkerOptions& options) {
    auto worker = WorkerClient::start(options);
    if (!worker) return worker.error();
    WorkerClient& running = **worker;
    hands_.push_back(
        {std::move(*worker), std::async(std::launch::async, [&running] { return running.wait(); }).share()});
    return {};
}

}  // namespace lumenfarm
