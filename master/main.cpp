#include "common/service/attendant.h"
#include "master/master_server.h"

#include <sys/resource.h>

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

/// lumenfarm-master: a MasterServer that ends on SIGTERM or SIGINT.
namespace {

constexpr int exit_usage = 2;

void declare(CLI::App& app, lumenfarm::MasterOptions& options) {
    app.set_config("--config", "/etc/lumenfarm/master.toml", "TOML file with these options");
    app.add_option("--listen", options.listen, "HOST:PORT to listen on")
        ->envname("LUMENFARM_LISTEN")
        ->capture_default_str();
    app.add_option("--storage", options.storage, "folder of jobs, scenes and solutions")
        ->envname("LUMENFARM_STORAGE")
        ->required();
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
    app.add_option("--checkpoint-seconds", options.checkpoint_seconds,
                   "between two snapshots of a job, from which a restart goes on [s]")
        ->envname("LUMENFARM_CHECKPOINT_SECONDS")
        ->check(CLI::Range(0.1, 86'400.0))
        ->capture_default_str();
    app.add_option("--audit-fraction", options.audit_fraction,
                   "of the results are traced again by a second worker, to find workers whose results are wrong")
        ->envname("LUMENFARM_AUDIT_FRACTION")
        ->check(CLI::Range(0.0, 1.0))
        ->capture_default_str();
    app.add_option("--keep-days", options.keep_days, "jobs that ended longer ago are removed; 0 keeps them")
        ->envname("LUMENFARM_KEEP_DAYS")
        ->check(CLI::Range(0.0, 36'500.0))
        ->capture_default_str();
    app.add_option("--keep-bytes", options.keep_bytes,
                   "most bytes of solutions, beyond which the job that ended first is removed; 0: any number")
        ->envname("LUMENFARM_KEEP_BYTES")
        ->transform(CLI::AsSizeValue(false))
        ->capture_default_str();
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
}

/// Each connection takes a descriptor, and most systems give a program fewer than limits::sessions_max at first.
void raise_descriptor_limit() {
    rlimit limit{};
    if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
    limit.rlim_cur = limit.rlim_max;
    setrlimit(RLIMIT_NOFILE, &limit);
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

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("Lumenfarm's master: keeps the queue of jobs and commits what workers trace.", "lumenfarm-master");
    lumenfarm::MasterOptions options;
    declare(app, options);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == 0) return app.exit(error);
        std::cerr << "lumenfarm-master: " << error.what() << "\n";
        return exit_usage;
    }
    spdlog::set_default_logger(spdlog::stderr_color_mt("lumenfarm-master"));
    raise_descriptor_limit();
    const lumenfarm::EndSignals signals;
    const auto master = lumenfarm::MasterServer::start(options);
    if (!master) {
        std::cerr << "lumenfarm-master: " << master.error().sentence << "\n";
        return lumenfarm::exit_code(master.error());
    }
    spdlog::info("listening on {}, storage '{}'", (*master)->address(), options.storage.string());
    return serve(**master, signals);
}
