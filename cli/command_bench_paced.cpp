#include "cli/bench_input.h"
#include "cli/commands.h"
#include "cli/job_options.h"
#include "cli/options.h"
#include "cli/stop_signals.h"
#include "common/service/descriptor_limit.h"
#include "common/support/limits.h"
#include "worker/paced/paced_session.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <string>
#include <utility>

/// `bench paced`: one process that stands for many workers.
namespace lumenfarm {
namespace {

class PacedBenchCommand : public Command {
public:
    PacedBenchCommand(CLI::App& bench, const FarmOptions& farm)
        : Command(bench, "paced",
                  "Stand for many workers, which have their results beforehand, to measure a master or relay that "
                  "was started with --paced-workers"),
          farm_(farm) {
        declare_bench_input(app_, input_);
        count_option(app_, "--workers", options_.workers, "Workers to stand for");
        real_option(app_, "--pace", options_.particles_per_s, "Particles a second of each of their threads")
            ->required()
            ->default_str("");
        count_option(app_, "--threads", options_.worker.threads, "Threads of each of them")->default_str("1");
        text_option(app_, "--name", options_.worker.name, "How the master calls them, before their number");
        app_.add_option("--cache", options_.worker.cache, "Folders of fetched scenes, before their number")
            ->type_name("DIR")
            ->required();
        text_option(app_, "--stored", stored_, "File of the results; traced and written when it is not there")
            ->type_name("FILE")
            ->required();
        isa_option(app_, options_.worker.isa);
        declare_path_options(app_, job_);
        declare_texel_option(app_, job_);
        declare_packing_option(app_, job_);
        options_.worker.threads = 1;
        options_.worker.name = "paced";
    }

    Result<void> execute(Console& console) override {
        if (options_.workers < 1 || options_.workers > limits::sessions_max)
            return bad_input("workers is " + std::to_string(options_.workers) + "; it must be from 1 to " +
                             std::to_string(limits::sessions_max));
        if (!std::isfinite(options_.particles_per_s) || options_.particles_per_s < 1)
            return bad_input("pace must be 1 particle a second or more");
        const StopSignals signals([] {});
        raise_descriptor_limit();
        spdlog::set_default_logger(spdlog::stderr_color_mt("paced"));
        spdlog::set_level(spdlog::level::err);  // what so many say
        options_.worker.master = farm_.master;
        const auto scene = read_bench_scene(app_, input_, console);
        if (!scene) return scene.error();
        const auto results = worker::PacedResults::make(scene->bytes, job_, stored_, options_.worker.isa);
        if (!results) return results.error();
        const auto workers = start_paced_workers(options_, *results);
        if (!workers) return workers.error();
        console.note(std::to_string(options_.workers) + " paced workers, until Ctrl+C");
        for (const auto& worker : *workers)
            if (auto ended = worker->wait(); !ended) return ended;
        return {};
    }

private:
    const FarmOptions& farm_;
    BenchInput input_;
    PacedOptions options_;
    JobSpec job_;
    std::string stored_;
};

}  // namespace

std::unique_ptr<Command> make_paced_bench_command(CLI::App& bench, const FarmOptions& farm) {
    return std::make_unique<PacedBenchCommand>(bench, farm);
}

}  // namespace lumenfarm
