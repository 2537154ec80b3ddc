#include "worker/worker_client.h"

#include "common/transport/fingerprint.h"
#include "worker/client_session.h"

#include <unistd.h>

#include <random>
#include <thread>
#include <utility>

namespace lumenfarm {

namespace {

std::string machine_name() {
    char name[limits::peer_name_bytes_max + 1] = {};
    return gethostname(name, sizeof name - 1) == 0 ? name : "worker";
}

std::uint64_t random_number() {
    std::random_device entropy;
    return std::uint64_t{entropy()} << 32 | entropy();
}

std::uint64_t memory_bytes() {
    const long pages = sysconf(_SC_PHYS_PAGES), page_bytes = sysconf(_SC_PAGE_SIZE);
    return pages > 0 && page_bytes > 0 ? static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page_bytes) : 0;
}

}  // namespace

Result<std::unique_ptr<WorkerClient>> WorkerClient::start(const WorkerOptions& options) {
    const auto master = net::HostPort::parse(options.master);
    if (!master) return master.error();
    if (options.threads > limits::threads_per_worker_max)
        return bad_input("a worker has at most " + std::to_string(limits::threads_per_worker_max) + " threads, not " +
                         std::to_string(options.threads));
    const Result<std::uint64_t> fingerprint =
        options.fingerprint != 0 ? options.fingerprint : transport_fingerprint(options.isa);
    if (!fingerprint) return fingerprint.error();
    worker::WorkerIdentity identity;
    identity.name = options.name.empty() ? machine_name() : options.name;
    identity.instance = random_number();
    identity.threads = options.threads > 0 ? options.threads : std::max(1u, std::thread::hardware_concurrency());
    identity.memory_bytes = options.memory_limit_bytes > 0 ? options.memory_limit_bytes : memory_bytes() / 4 * 3;
    identity.parts_only = options.parts_only;
    identity.isa = options.isa;
    identity.fingerprint = *fingerprint;
    return std::unique_ptr<WorkerClient>(new WorkerClient(std::make_unique<Running>(options, *master, identity)));
}

WorkerClient::WorkerClient(std::unique_ptr<Running> running) : running_(std::move(running)) {}
WorkerClient::~WorkerClient() = default;

void WorkerClient::drain() { running_->drain(); }
void WorkerClient::end_now() { running_->end_now(); }
bool WorkerClient::ended() const { return running_->ended(); }
std::vector<ServingThread> WorkerClient::threads() { return running_->threads(); }
std::string WorkerClient::summary() const { return running_->summary(); }
Result<void> WorkerClient::wait() { return running_->wait(); }
bool WorkerClient::connected() const { return running_->connected(); }
std::uint64_t WorkerClient::particles_merged() const { return running_->particles_merged(); }

}  // namespace lumenfarm
