#include "worker/worker_client.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include <csignal>
#include <iostream>
#include <string>
#include <thread>

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
    app.add_option("--name", options.name, "how the master calls this worker [the machine's name]")
        ->envname("LUMENFARM_NAME");
    app.add_option("--isa", options.isa, "Embree's instruction set: sse4.2, avx2 or avx512 [the best of this machine]")
        ->envname("LUMENFARM_ISA")
        ->check(CLI::IsMember({"sse4.2", "avx2", "avx512"}));
    app.add_flag("--idle-priority,!--normal-priority", options.idle_priority,
                 "trace only when nothing else wants the cores (the default)")
        ->envname("LUMENFARM_IDLE_PRIORITY");
}

/// To be called before any thread starts: they all inherit the mask.
sigset_t block_signals() {
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    return signals;
}

/// Runs the worker until a signal drains it or the master refuses it.
lumenfarm::Result<void> run(lumenfarm::WorkerClient& worker, const sigset_t& signals) {
    std::thread listener([&] {
        int signal = 0;
        sigwait(&signals, &signal);
        worker.drain();
    });
    auto ended = worker.wait();
    // wakes the listener when no signal came
    pthread_kill(listener.native_handle(), SIGTERM);
    listener.join();
    return ended;
}

}  // namespace

int main(int argc, char** argv) {
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
    const sigset_t signals = block_signals();
    const auto worker = lumenfarm::WorkerClient::start(options);
    if (!worker) {
        std::cerr << "lumenfarm-worker: " << worker.error().sentence << "\n";
        return lumenfarm::exit_code(worker.error());
    }
    if (const auto ended = run(**worker, signals); !ended) {
        std::cerr << "lumenfarm-worker: " << ended.error().sentence << "\n";
        return lumenfarm::exit_code(ended.error());
    }
    spdlog::info("drained: {} particles were merged", (*worker)->particles_merged());
    return 0;
}
