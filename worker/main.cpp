#include "common/service/attendant.h"
#include "worker/worker_client.h"

#include <malloc.h>

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include <cstdlib>
#include <cstring>
#include <iostream>

/// lumenfarm-worker: a WorkerClient that drains on SIGTERM or SIGINT.
namespace {

constexpr int exit_usage = 2;

void declare(CLI::App& app, lumenfarm::WorkerOptions& options) {
    app.set_config("--config", "/etc/lumenfarm/worker.toml", "TOML file with these options");
    app.add_option("--master", options.master, "HOST:PORT of the master")
        ->envname("LUMENFARM_MASTER")
        ->capture_default_str();
    app.add_option("--threads", options.threads, "tracing threads; 0 is one for each core")
        ->envname("LUMENFARM_THREADS")
        ->capture_default_str();
    app.add_option("--cache", options.cache,
                   "folder of fetched scenes [$XDG_CACHE_HOME/lumenfarm or /var/cache/lumenfarm]")
        ->envname("LUMENFARM_CACHE");
    app.add_option("--cache-bytes", options.cache_bytes_max, "most bytes in that folder")
        ->envname("LUMENFARM_CACHE_BYTES")
        ->transform(CLI::AsSizeValue(false))
        ->capture_default_str();
    app.add_option("--memory-limit", options.memory_limit_bytes,
                   "most memory to take, e.g. 2GB; larger scenes need --strategy subspaces [3/4 of the machine's]")
        ->envname("LUMENFARM_MEMORY_LIMIT")
        ->transform(CLI::AsSizeValue(false));
    app.add_flag("--parts-only", options.parts_only,
                 "with strategy subspaces hold scenes in parts, even where they would fit whole (for measurements)")
        ->envname("LUMENFARM_PARTS_ONLY");
    app.add_option("--name", options.name, "how the master calls this worker [the machine's name]")
        ->envname("LUMENFARM_NAME");
    app.add_option("--isa", options.isa, "Embree's instruction set: sse4.2, avx2 or avx512 [the best of this machine]")
        ->envname("LUMENFARM_ISA")
        ->check(CLI::IsMember({"sse4.2", "avx2", "avx512"}));
    app.add_flag("--idle-priority,!--normal-priority", options.idle_priority,
                 "trace only when nothing else wants the cores (the default)")
        ->envname("LUMENFARM_IDLE_PRIORITY");
    app.add_option("--drain-seconds", options.drain_seconds,
                   "most time from SIGTERM to the end, to hand over what is done [s]")
        ->envname("LUMENFARM_DRAIN_SECONDS")
        ->check(CLI::Range(0.0, lumenfarm::limits::drain_seconds_max))
        ->capture_default_str();
}

/// Serves until a signal drains it, a second one ends it, or the master refuses it.
lumenfarm::Result<void> serve(lumenfarm::WorkerClient& worker, const lumenfarm::EndSignals& signals) {
    lumenfarm::Attendant attendant(signals, worker.threads(), [&worker] { return worker.summary(); });
    attendant.ready();
    bool draining = false;
    while (!worker.ended()) {
        const auto signal = attendant.look();
        if (!signal) continue;
        spdlog::info("{}{}: the worker {}", strsignal(*signal), draining ? " again" : "",
                     draining ? "ends at once, and its work goes to others" : "hands back its work and ends");
        if (!draining) attendant.stopping();
        draining ? worker.end_now() : worker.drain();
        draining = true;
    }
    return worker.wait();
}

}  // namespace

int main(int argc, char** argv) {
    // Parts of scenes come and go: what one of them took is to go back to the machine, not to stay between other
    // things. Left alone, glibc keeps blocks up to 32 MiB in its heap once such a block was freed.
    mallopt(M_MMAP_THRESHOLD, 128 << 10);
    CLI::App app("Lumenfarm's worker: pulls sets of particles from a master and traces them.", "lumenfarm-worker");
    lumenfarm::WorkerOptions options;
    declare(app, options);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == 0) return app.exit(error);
        std::cerr << "lumenfarm-worker: " << error.what() << "\n";
        return exit_usage;
    }
    spdlog::set_default_logger(spdlog::stderr_color_mt("lumenfarm-worker"));
    const lumenfarm::EndSignals signals;
    const auto worker = lumenfarm::WorkerClient::start(options);
    if (!worker) {
        std::cerr << "lumenfarm-worker: " << worker.error().sentence << "\n";
        return lumenfarm::exit_code(worker.error());
    }
    const auto ended = serve(**worker, signals);
    if (!ended) std::cerr << "lumenfarm-worker: " << ended.error().sentence << "\n";
    if (ended) spdlog::info("drained: {} particles were merged", (*worker)->particles_merged());
    // a thread may be in the midst of a slice, or of a large scene: nobody waits for that any more
    std::_Exit(ended ? 0 : lumenfarm::exit_code(ended.error()));
}
