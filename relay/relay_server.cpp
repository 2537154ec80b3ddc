#include "relay/relay_server.h"

#include "common/support/file.h"
#include "common/transport/fingerprint.h"
#include "master/disk/posix_disk.h"
#include "relay/relay_session.h"

#include <unistd.h>

#include <random>
#include <utility>

namespace lumenfarm {

namespace {

/// Another one than that of a worker on the same machine.
std::string default_name() {
    char name[limits::peer_name_bytes_max - 8] = {};
    return gethostname(name, sizeof name - 1) == 0 ? std::string(name) + " (relay)" : "relay";
}

}  // namespace

Result<std::unique_ptr<RelayServer>> RelayServer::start(const RelayOptions& options) {
    const auto upstream = net::HostPort::parse(options.upstream);
    if (!upstream) return upstream.error();
    if (options.storage.empty()) return bad_input("a relay needs a storage folder: --storage DIR");
    if (const auto made = make_folder(options.storage); !made) return made.error();
    auto lock = StorageLock::take(options.storage);
    if (!lock) return lock.error();
    std::unique_ptr<Disk> disk = std::make_unique<PosixDisk>();
    auto files = std::make_unique<FileStore>(*disk, options.storage / "relay");
    if (const auto opened = files->open(); !opened) return opened.error();
    // those of jobs of an earlier life
    if (const auto removed = files->remove_others({}); !removed) return removed.error();
    const auto fingerprint = farm_fingerprint(options.isa, options.paced_workers);
    if (!fingerprint) return fingerprint.error();

    std::random_device entropy;
    relay::RelayIdentity identity;
    identity.name = options.name.empty() ? default_name() : options.name;
    identity.instance = std::uint64_t{entropy()} << 32 | entropy();
    identity.isa = options.isa;
    identity.fingerprint = *fingerprint;
    MasterPolicy farm = policy_of(options, *fingerprint);
    farm.epoch = entropy();  // leases of an earlier life are not of this one
    farm.upstream = upstream->text();
    farm.instance = identity.instance;
    auto running = std::make_unique<Running>(options, *upstream, identity, farm, std::move(*lock), std::move(disk),
                                             std::move(files));
    if (const auto listening = running->listen(options.listen, options.allow_plaintext); !listening)
        return listening.error();
    running->run();
    return std::unique_ptr<RelayServer>(new RelayServer(std::move(running)));
}

RelayServer::RelayServer(std::unique_ptr<Running> running) : running_(std::move(running)) {}
RelayServer::~RelayServer() = default;

const std::string& RelayServer::address() const { return running_->address(); }
void RelayServer::drain() { running_->drain(); }
void RelayServer::end_now() { running_->end_now(); }
bool RelayServer::ended() const { return running_->ended(); }
Result<void> RelayServer::wait() { return running_->wait(); }
std::uint64_t RelayServer::particles_merged() const { return running_->particles_merged(); }
std::vector<ServingThread> RelayServer::threads() { return running_->threads(); }
std::string RelayServer::summary() const { return running_->summary(); }

}  // namespace lumenfarm
