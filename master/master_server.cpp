#include "master/master_server.h"

#include "common/support/file.h"
#include "common/transport/fingerprint.h"
#include "master/disk/posix_disk.h"
#include "master/server_session.h"

#include <spdlog/spdlog.h>
#include <boost/asio/post.hpp>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <random>
#include <utility>

namespace lumenfarm {

namespace {

/// Result of a call that a stopped master does not answer.
Error stopped() { return failed("the master was stopped"); }

}  // namespace

template <class Task>
auto MasterServer::Running::ask(Task task) -> std::optional<decltype(task())> {
    using Answer = decltype(task());
    auto promise = std::make_shared<std::promise<Answer>>();
    auto answer = promise->get_future();
    boost::asio::post(io_, [promise, task = std::move(task)]() mutable { promise->set_value(task()); });
    promise.reset();
    while (answer.wait_for(std::chrono::milliseconds(100)) != std::future_status::ready)
        if (io_.stopped()) return std::nullopt;
    return answer.get();
}

Result<std::unique_ptr<MasterServer>> MasterServer::start(const MasterOptions& options) {
    if (options.storage.empty()) return bad_input("a master needs a storage folder: --storage DIR");
    if (const auto made = make_folder(options.storage); !made) return made.error();
    auto lock = StorageLock::take(options.storage);
    if (!lock) return lock.error();
    std::unique_ptr<Disk> disk = std::make_unique<PosixDisk>();
    auto storage = Storage::open(*disk, options.storage);
    if (!storage) return storage.error();
    auto begun = (*storage)->start();
    if (!begun) return begun.error();
    const auto fingerprint = farm_fingerprint(options.isa, options.paced_workers);
    if (!fingerprint) return fingerprint.error();

    MasterPolicy policy = policy_of(options, *fingerprint);
    policy.epoch = begun->life;
    policy.first_job = begun->next_job;
    policy.checkpoint_seconds = options.checkpoint_seconds;
    policy.recut_above = options.recut_above > 0 ? std::optional(options.recut_above) : std::nullopt;
    policy.audit_fraction = options.audit_fraction;
    std::random_device entropy;
    policy.audit_key = std::uint64_t{entropy()} << 32 | entropy();
    policy.started_unix_seconds = std::time(nullptr);
    if (options.keep_days > 0) policy.keep_seconds = options.keep_days * 86'400;
    if (options.keep_bytes > 0) policy.keep_bytes = options.keep_bytes;
    auto running = std::make_unique<Running>(policy, std::move(*lock), std::move(disk), std::move(*storage));
    if (const auto listening = running->listen(options.listen, options.allow_plaintext); !listening)
        return listening.error();
    running->run(std::move(begun->records), begun->warnings);
    return std::unique_ptr<MasterServer>(new MasterServer(std::move(running)));
}

MasterServer::MasterServer(std::unique_ptr<Running> running) : running_(std::move(running)) {}
MasterServer::~MasterServer() = default;

std::uint16_t MasterServer::port() const { return running_->port(); }
const std::string& MasterServer::address() const { return running_->address(); }
void MasterServer::stop() { running_->stop(); }
std::vector<ServingThread> MasterServer::threads() { return running_->threads(); }
std::string MasterServer::summary() const { return running_->summary(); }
std::optional<Error> MasterServer::failure() const { return running_->failure(); }

Result<JobId> MasterServer::submit(const JobSpec& spec, std::span<const std::byte> scene_bytes) {
    return running_->submit(spec, scene_bytes);
}

Result<wire::JobStatus> MasterServer::status(JobId job) const {
    const auto status = running_->ask([&] { return running_->core().status(job, running_->now_s()); });
    if (const auto failure = running_->failure()) return *failure;
    if (!status) return stopped();
    if (!*status) return bad_input("there is no job " + std::to_string(job));
    return **status;
}

Result<wire::JobStatus> MasterServer::wait(JobId job, double seconds) const {
    using Clock = std::chrono::steady_clock;
    const auto until = Clock::now() + std::chrono::duration<double>(seconds);
    while (true) {
        auto now = status(job);
        const double left_s = std::chrono::duration<double>(until - Clock::now()).count();
        if (!now || wire::is_over(now->state) || left_s <= 0) return now;
        running_->wait_for_change(std::min(left_s, 0.1));
    }
}

void MasterServer::cancel(JobId job) {
    running_->ask([&] {
        running_->carry_out(running_->core().cancel(job, running_->now_s()));
        return true;
    });
}

std::vector<wire::WorkerStatus> MasterServer::workers() const {
    return running_->ask([&] { return running_->core().workers(running_->now_s()); })
        .value_or(std::vector<wire::WorkerStatus>{});
}

Result<JobFiles> MasterServer::files(JobId job) const {
    const auto record = running_->ask([&]() -> std::optional<JobRecord> {
        const JobRecord* found = running_->core().record(job);
        return found ? std::optional(*found) : std::nullopt;
    });
    if (!record) return stopped();
    const std::string name = "job " + std::to_string(job);
    if (!*record) return bad_input("there is no " + name);
    const JobRecord& found = **record;
    if (!found.over()) return failed(name + " has no result yet");
    if (!found.has_solution)
        return failed(name + " ended without a result" +
                      (found.status.sentence.empty() ? std::string() : ": " + found.status.sentence));
    const FileStore& files = running_->files();
    return JobFiles{files.path(found.status.scene), files.path(found.solution_file), found.complete};
}

}  // namespace lumenfarm
