#include "worker/slot_thread.h"

#include "common/service/thread_time.h"

#include <sys/resource.h>

#include <chrono>
#include <utility>

namespace lumenfarm::worker {

namespace {

constexpr int idle_nice = 19;

double wall_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

}  // namespace

SlotThread::SlotThread(bool idle_priority, OnReport on_report)
    : on_report_(std::move(on_report)), slot_(SlotClocks{wall_s, thread_cpu_seconds}) {
    thread_ = std::thread([this, idle_priority] { run(idle_priority); });
}

SlotThread::~SlotThread() {
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
    }
    given_.notify_all();
    thread_.join();
}

void SlotThread::give(Command command) {
    {
        const std::lock_guard lock(mutex_);
        command_ = std::move(command);
        interrupt_ = SlotAsk::nothing;
        busy_ = true;
    }
    given_.notify_all();
}

void SlotThread::start(SetWork work) { give({std::move(work), SlotAsk::nothing}); }
void SlotThread::resume() { give({}); }
void SlotThread::tell(SlotAsk ask) { give({std::nullopt, ask}); }

void SlotThread::interrupt(SlotAsk ask) {
    const std::lock_guard lock(mutex_);
    // to throw away outweighs to hand over
    if (busy_ && interrupt_ != SlotAsk::abandon) interrupt_ = ask;
}

void SlotThread::ask(std::function<void()> answer) {
    {
        const std::lock_guard lock(mutex_);
        answer_ = std::move(answer);
    }
    given_.notify_all();
}

void SlotThread::answer() {
    if (const auto answer = std::exchange(answer_, nullptr)) answer();
}

void SlotThread::run(bool idle_priority) {
    // on Linux this is the priority of the calling thread alone
    if (idle_priority) setpriority(PRIO_PROCESS, 0, idle_nice);
    std::unique_lock lock(mutex_);
    while (true) {
        given_.wait(lock, [this] { return command_ || ending_ || answer_; });
        answer();
        if (ending_) return;
        if (!command_) continue;
        Command command = std::move(*command_);
        command_.reset();
        lock.unlock();
        SlotReport report = obey(std::move(command));
        lock.lock();
        busy_ = false;
        if (ending_) return;
        lock.unlock();
        on_report_(std::move(report));
        lock.lock();
    }
}

SlotReport SlotThread::obey(Command command) {
    if (command.work) slot_.begin(std::move(*command.work));
    SlotAsk ask = command.ask;
    while (true) {
        if (auto report = slot_.advance(ask)) return std::move(*report);
        const std::lock_guard lock(mutex_);
        answer();
        ask = ending_ ? SlotAsk::abandon : std::exchange(interrupt_, SlotAsk::nothing);
    }
}

}  // namespace lumenfarm::worker
