#include "worker/paced/paced_session.h"

#include "common/transport/fingerprint.h"
#include "worker/paced/paced_slot.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>

#include <chrono>
#include <string>
#include <utility>

namespace lumenfarm {

namespace asio = boost::asio;

namespace {

using Clock = std::chrono::steady_clock;

double now_s() { return std::chrono::duration<double>(Clock::now().time_since_epoch()).count(); }

/// A PacedSlot with a timer of the worker's loop, from which it is also commanded.
class TimedSlot : public worker::Slot {
public:
    TimedSlot(worker::PacedSlot slot, asio::io_context& loop, worker::OnReport on_report)
        : slot_(std::move(slot)), loop_(loop), timer_(loop), on_report_(std::move(on_report)) {}

    void start(SetWork work) override {
        slot_.begin(std::move(work));
        resume();
    }
    void resume() override {
        slot_.go_on(now_s());
        tracing_ = true;
        wait();
    }
    void tell(SlotAsk ask) override { on_report_(slot_.stop(ask)); }
    void interrupt(SlotAsk ask) override {
        if (!tracing_) return;
        slot_.interrupt(ask, now_s());
        wait();
    }
    void ask(std::function<void()> answer) override { asio::post(loop_, std::move(answer)); }

private:
    void wait() {
        const std::chrono::duration<double> until(slot_.stops_s());
        timer_.expires_at(Clock::time_point(std::chrono::duration_cast<Clock::duration>(until)));
        // the end of an earlier wait may be on its way already
        timer_.async_wait([this, wait = ++waits_](const boost::system::error_code& error) {
            if (error || wait != waits_) return;
            tracing_ = false;
            on_report_(slot_.stop());
        });
    }

    worker::PacedSlot slot_;
    asio::io_context& loop_;
    asio::steady_timer timer_;
    worker::OnReport on_report_;
    bool tracing_ = false;
    std::uint64_t waits_ = 0;
};

}  // namespace

Result<std::vector<std::unique_ptr<WorkerClient>>> start_paced_workers(
    const PacedOptions& options, const std::shared_ptr<const worker::PacedResults>& results) {
    const auto fingerprint = transport_fingerprint(options.worker.isa);
    if (!fingerprint) return fingerprint.error();
    std::vector<std::unique_ptr<WorkerClient>> workers;
    for (std::uint32_t number = 1; number <= options.workers; ++number) {
        WorkerOptions worker = options.worker;
        worker.name += "-" + std::to_string(number);
        worker.cache += "-" + std::to_string(number);
        worker.fingerprint = paced_fingerprint(*fingerprint);
        worker.make_job = [results](const wire::JobInfo& info, std::span<const std::byte>) {
            return results->context_of(info);
        };
        worker.make_slot = [results, pace = options.particles_per_s](asio::io_context& loop,
                                                                     worker::OnReport on_report) {
            return std::make_unique<TimedSlot>(worker::PacedSlot(results, pace), loop, std::move(on_report));
        };
        auto started = WorkerClient::start(worker);
        if (!started) return started.error();
        workers.push_back(std::move(*started));
    }
    return workers;
}

}  // namespace lumenfarm
