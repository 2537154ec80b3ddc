#include "common/service/attendant.h"
#include "common/service/descriptor_limit.h"
#include "master/master_server.h"
#include "relay/relay_server.h"

#include <malloc.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <future>
#include <iostream>
#include <optional>
#include <string>

/// lumenfarm-master: a MasterServer, or with --upstream a RelayServer, that ends on SIGTERM or SIGINT.
namespace {

constexpr int exit_usage = 2;

struct Options {
    lumenfarm::MasterOptions master;
    lumenfarm::RelayOptions relay;  ///< when it has an upstream; what both have is taken from the master's
};

/// What only a master has; a relay keeps nothing.
void declare_keeping(CLI::App& app, lumenfarm::MasterOptions& options, CLI::Option* upstream) {
    app.add_option("--checkpoint-seconds", options.checkpoint_seconds,
                   "between two snapshots of a job, from which a restart goes on [s]")
        ->envname("LUMENFARM_CHECKPOINT_SECONDS")
        ->check(CLI::Range(0.1, 86'400.0))
        ->capture_default_str()
        ->excludes(upstream);
    app.add_option("--recut-above", options.recut_above,
                   "strategy subspaces: cut a scene anew when the largest share of a subspace in the work so far is so "
                   "many times the mean; 0: never")
        ->envname("LUMENFARM_RECUT_ABOVE")
        ->check(CLI::Range(0.0, 1e6))
        ->capture_default_str()
        ->excludes(upstream);
    app.add_option("--audit-fraction", options.audit_fraction,
                   "of the results are traced again by a second worker, to find workers whose results are wrong")
        ->envname("LUMENFARM_AUDIT_FRACTION")
        ->check(CLI::Range(0.0, 1.0))
        ->capture_default_str()
        ->excludes(upstream);
    app.add_option("--keep-days", options.keep_days, "jobs that ended longer ago are removed; 0 keeps them")
        ->envname("LUMENFARM_KEEP_DAYS")
        ->check(CLI::Range(0.0, 36'500.0))
        ->capture_default_str()
        ->excludes(upstream);
    app.add_option("--keep-bytes", options.keep_bytes,
                   "most bytes of solutions, beyond which the job that ended first is removed; 0: any number")
        ->envname("LUMENFARM_KEEP_BYTES")
        ->transform(CLI::AsSizeValue(false))
        ->capture_default_str()
        ->excludes(upstream);
}

void declare(CLI::App& app, Options& all) {
    lumenfarm::MasterOptions& options = all.master;
    app.set_config("--config", "/etc/lumenfarm/master.toml", "TOML file with these options");
    app.add_option("--listen", options.listen, "HOST:PORT to listen on")
        ->envname("LUMENFARM_LISTEN")
        ->capture_default_str();
    app.add_option("--storage", options.storage, "folder of jobs, scenes and solutions")
        ->envname("LUMENFARM_STORAGE")
        ->required();
    CLI::Option* upstream =
        app.add_option("--upstream", all.relay.upstream,
                       "HOST:PORT of a master to be a relay of: pull its work, let the workers of this one do it, and "
                       "hand up what they give in sum")
            ->envname("LUMENFARM_UPSTREAM");
    app.add_option("--name", all.relay.name, "a relay: how its master calls it [the machine's name, and (relay)]")
        ->envname("LUMENFARM_NAME");
    app.add_option("--drain-seconds", all.relay.drain_seconds,
                   "a relay: most time from SIGTERM to the end, to hand up what is done [s]")
        ->envname("LUMENFARM_DRAIN_SECONDS")
        ->check(CLI::Range(0.0, lumenfarm::limits::drain_seconds_max))
        ->capture_default_str();
    declare_keeping(app, options, upstream);
    app.add_flag(
           "--allow-plaintext", options.allow_plaintext,
           "listen beyond loopback though nothing is encrypted or authenticated: everybody who reaches the port may "
           "use the farm, read its scenes and results, and feed it wrong ones")
        ->envname("LUMENFARM_ALLOW_PLAINTEXT");
    app.add_option("--set-seconds", options.set_target_seconds, "how long a set of automatic size takes one thread [s]")
        ->envname("LUMENFARM_SET_SECONDS")
        ->check(CLI::Range(0.01, 600.0))
        ->capture_default_str();
    app.add_option("--flush-seconds", options.flush_seconds, "packing maps: between two results of a thread [s]")
        ->envname("LUMENFARM_FLUSH_SECONDS")
        ->check(CLI::Range(0.05, 600.0))
        ->capture_default_str();
    app.add_option("--results-in-flight", options.results_in_flight,
                   "results that a worker may have sent without an answer")
        ->envname("LUMENFARM_RESULTS_IN_FLIGHT")
        ->check(CLI::Range(1u, lumenfarm::limits::results_in_flight_max))
        ->capture_default_str();
    app.add_flag("--compress", options.compress, "workers compress their results: for slow networks")
        ->envname("LUMENFARM_COMPRESS");
    app.add_option("--dead-seconds", options.dead_seconds,
                   "a connection that is silent for so long is closed; both sides speak three times as often [s]")
        ->envname("LUMENFARM_DEAD_SECONDS")
        ->check(CLI::Range(lumenfarm::limits::dead_seconds_min, lumenfarm::limits::dead_seconds_max))
        ->capture_default_str();
    app.add_option("--reconnect-seconds", options.reconnect_seconds,
                   "sets of a lost connection wait so long for their worker before others get them [s]")
        ->envname("LUMENFARM_RECONNECT_SECONDS")
        ->check(CLI::Range(0.0, 3'600.0))
        ->capture_default_str();
    app.add_flag("--paced-workers", options.paced_workers,
                 "take paced workers (lumenfarm bench paced), and no others: their results are for measurements")
        ->envname("LUMENFARM_PACED_WORKERS");
}

/// Everything that was acknowledged is on the disk: an end at any instant loses none of it.
[[noreturn]] void end_at_once(int signal) {
    spdlog::warn("{} again: the master ends at once", strsignal(signal));
    std::_Exit(0);
}

/// Serves until a signal comes or the disk fails. Gives the exit code.
int serve(lumenfarm::MasterServer& master, const lumenfarm::EndSignals& signals) {
    lumenfarm::Attendant attendant(signals, master.threads(), [&master] { return master.summary(); });
    attendant.ready();
    std::optional<int> signal;
    while (!signal && !master.failure()) signal = attendant.look();
    attendant.stopping();
    if (signal) spdlog::info("{}: the master ends; unfinished jobs go on when it starts again", strsignal(*signal));
    const auto stopped = std::async(std::launch::async, [&master] { master.stop(); });
    while (stopped.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
        if (const auto again = attendant.look()) end_at_once(*again);
    const auto failure = master.failure();
    return failure ? lumenfarm::exit_code(*failure) : 0;
}

/// Serves until a signal drains it, a second one ends it, or the master above refuses it. Gives the exit code.
int serve(lumenfarm::RelayServer& relay, const lumenfarm::EndSignals& signals) {
    lumenfarm::Attendant attendant(signals, relay.threads(), [&relay] { return relay.summary(); });
    attendant.ready();
    bool draining = false;
    while (!relay.ended()) {
        const auto signal = attendant.look();
        if (!signal) continue;
        spdlog::info("{}{}: the relay {}", strsignal(*signal), draining ? " again" : "",
                     draining ? "ends at once, and its work goes to others" : "hands up what is done and ends");
        if (!draining) attendant.stopping();
        draining ? relay.end_now() : relay.drain();
        draining = true;
    }
    const auto ended = relay.wait();
    if (!ended) std::cerr << "lumenfarm-master: " << ended.error().sentence << "\n";
    if (ended) spdlog::info("drained: {} particles were merged", relay.particles_merged());
    return ended ? 0 : lumenfarm::exit_code(ended.error());
}

/// Starts it and serves. Gives the exit code.
template <class Server, class ServerOptions>
int run(const ServerOptions& options, const std::string& what) {
    const lumenfarm::EndSignals signals;
    const auto server = Server::start(options);
    if (!server) {
        std::cerr << "lumenfarm-master: " << server.error().sentence << "\n";
        return lumenfarm::exit_code(server.error());
    }
    spdlog::info("listening on {}, {}", (*server)->address(), what);
    return serve(**server, signals);
}

lumenfarm::RelayOptions relay_of(const Options& options) {
    lumenfarm::RelayOptions relay = options.relay;
    static_cast<lumenfarm::ServingOptions&>(relay) = options.master;
    return relay;
}

/// Frames come and go by the thousand: their memory is kept for the next ones. Left alone, glibc gives it back to the
/// kernel and takes it again, a page fault for every 256 hits. What is larger than a frame goes back, as ever.
void keep_memory_of_frames() {
    mallopt(M_MMAP_THRESHOLD, 2 * lumenfarm::limits::frame_payload_bytes_max);
    mallopt(M_TRIM_THRESHOLD, 64 << 20);
}

}  // namespace

int main(int argc, char** argv) {
    keep_memory_of_frames();
    CLI::App app("Lumenfarm's master: keeps the queue of jobs and commits what workers trace.", "lumenfarm-master");
    Options options;
    declare(app, options);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == 0) return app.exit(error);
        std::cerr << "lumenfarm-master: " << error.what() << "\n";
        return exit_usage;
    }
    spdlog::set_default_logger(spdlog::stderr_color_mt("lumenfarm-master"));
    lumenfarm::raise_descriptor_limit();
    if (options.relay.upstream.empty())
        return run<lumenfarm::MasterServer>(options.master, "storage '" + options.master.storage.string() + "'");
    return run<lumenfarm::RelayServer>(relay_of(options), "a relay of " + options.relay.upstream);
}
