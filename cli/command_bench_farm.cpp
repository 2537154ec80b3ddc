#include "cli/bench/farm_bench.h"
#include "cli/bench/farm_report.h"
#include "cli/bench_input.h"
#include "cli/commands.h"
#include "cli/job_options.h"
#include "cli/options.h"
#include "cli/output_folder.h"
#include "cli/products/json_text.h"
#include "cli/stop_signals.h"
#include "cli/temporary_folder.h"
#include "common/support/file.h"
#include "common/support/limits.h"
#include "worker/paced/paced_results.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

/// `bench farm`: how well a farm shares its work out.
namespace lumenfarm {
namespace {

constexpr std::uint64_t workers_max = 64;
constexpr std::uint64_t paced_workers_max = 4'000;
constexpr std::uint32_t relays_max = 16;
constexpr std::uint32_t jobs_max = 1'000;
constexpr std::uint32_t runs_max = 1'000;
constexpr std::size_t values_max = 64;
const std::vector<std::uint32_t> swept_hits{1, 100, 1'000, 5'000, 50'000};

class FarmBenchCommand : public Command {
public:
    explicit FarmBenchCommand(CLI::App& bench)
        : Command(bench, "farm", "Compare farms of real processes on this computer: speed-up, efficiency, traffic") {
        declare_bench_input(app_, input_);
        text_option(app_, "-o,--output", output_, "Folder for the results")->type_name("DIR")->required();
        counts_option(app_, "--workers", workers_, "Numbers of workers to compare");
        counts_option(app_, "--particles", particles_, "Particles of the jobs");
        count_option(app_, "--relays", options_.relays, "Relays between the master and all workers");
        count_option(app_, "--threads", options_.threads, "Threads of each worker");
        count_option(app_, "--runs", options_.runs, "Runs of each, taken in turn; the medians are shown");
        choice_option<bool>(app_, "--sweep", sweep_, {{"none", false}, {"hits-per-message", true}},
                            "Compare messages of 1 to 50,000 hits, too");
        count_option(app_, "--jobs", options_.jobs, "Jobs in a run, all alike, submitted together");
        isa_option(app_, options_.isa);
        app_.add_option("--memory-limit", options_.memory_limit_bytes, "Most memory that each worker takes, e.g. 2GB")
            ->type_name("BYTES")
            ->envname(environment_name("memory-limit"))
            ->transform(CLI::AsSizeValue(false).description(""));
        flag_option(app_, "--parts-only", options_.parts_only,
                    "With subspaces: workers hold the scene in parts, even where it would fit whole");
        // what the environment says of these is for a farm of its own
        real_option(app_, "--set-seconds", options_.set_seconds, "As lumenfarm-master's; 0: its default")->envname("");
        real_option(app_, "--flush-seconds", options_.flush_seconds, "As lumenfarm-master's; 0: its default")
            ->envname("");
        count_option(app_, "--results-in-flight", options_.results_in_flight, "As lumenfarm-master's; 0: its default")
            ->envname("");
        flag_option(app_, "--compress", options_.compress, "As lumenfarm-master's")->envname("");
        real_option(app_, "--pace", paced_.particles_per_s,
                    "Paced workers, which stand for computers that trace so many particles a second with each thread; "
                    "0: workers that trace");
        count_option(app_, "--slow", paced_.slow, "Of the paced workers so many are ten times slower");
        count_option(app_, "--stopped", paced_.stopped, "Of the paced workers so many stop in the middle");
        declare_path_options(app_, options_.job);
        declare_texel_option(app_, options_.job);
        declare_way_options(app_, options_.job);
    }

    Result<void> execute(Console& console) override;

private:
    Result<void> check_options();
    std::string run_line(const FarmRun& run, std::size_t done) const;
    std::size_t runs_in_all() const;
    Result<void> write(const OutputFolder& folder, const std::vector<FarmRun>& runs, Console& console) const;

    Result<void> prepare_paced(const CompiledScene& scene, const std::filesystem::path& folder);

    BenchInput input_;
    FarmBenchOptions options_;
    PacedBench paced_;
    std::vector<std::uint64_t> workers_{1, 2};
    std::vector<std::uint64_t> particles_{25'000, 205'000};
    std::string output_;
    bool sweep_ = false;
};

Result<void> check_each(const char* name, const std::vector<std::uint64_t>& values, std::uint64_t most) {
    for (const std::uint64_t value : values)
        if (value < 1 || value > most)
            return bad_input(std::string(name) + " has " + std::to_string(value) + "; each must be from 1 to " +
                             std::to_string(most));
    if (values.size() > values_max)
        return bad_input(std::string(name) + " has more than " + std::to_string(values_max) + " numbers");
    return {};
}

Result<void> check_one(const char* name, std::uint64_t value, std::uint64_t most) {
    if (value >= 1 && value <= most) return {};
    return bad_input(std::string(name) + " is " + std::to_string(value) + "; it must be from 1 to " +
                     std::to_string(most));
}

Result<void> FarmBenchCommand::check_options() {
    const bool paced = paced_.particles_per_s != 0;
    const std::uint64_t most = paced ? paced_workers_max : workers_max;
    if (auto checked = check_each("workers", workers_, most); !checked) return checked;
    if (auto checked = check_one("jobs", options_.jobs, jobs_max); !checked) return checked;
    const double slowest = paced_.slow > 0 ? PacedBench::slowness : 1;
    if (paced && !(std::isfinite(paced_.particles_per_s) && paced_.particles_per_s >= slowest))
        return bad_input("the slowest pace must be 1 particle a second or more");
    if (!paced && paced_.slow + paced_.stopped > 0) return bad_input("slow and stopped workers are paced: say --pace");
    for (const std::uint64_t workers : workers_)
        if (paced && std::uint64_t{paced_.slow} + paced_.stopped >= workers)
            return bad_input("of " + std::to_string(workers) +
                             " workers at least one must be neither slow nor stopped");
    if (auto checked = check_each("particles", particles_, limits::particles_max); !checked) return checked;
    if (auto checked = check_one("threads", options_.threads, limits::threads_per_worker_max); !checked) return checked;
    if (auto checked = check_one("runs", options_.runs, runs_max); !checked) return checked;
    if (options_.relays > relays_max)
        return bad_input("relays is " + std::to_string(options_.relays) + "; it must be from 0 to " +
                         std::to_string(relays_max));
    if (sweep_ && options_.job.packing == Packing::maps)
        return bad_input("packing maps sends no hits; sweep hits-per-message with packing records");
    if (sweep_) options_.job.packing = Packing::records;
    if (sweep_) options_.hits_per_message = swept_hits;
    for (const std::uint64_t workers : workers_) options_.workers.push_back(static_cast<std::uint32_t>(workers));
    options_.particles = particles_;
    options_.job.particles = particles_.front();
    return validate(options_.job);
}

std::size_t FarmBenchCommand::runs_in_all() const {
    const std::size_t granularities = std::max<std::size_t>(1, options_.hits_per_message.size());
    return options_.runs * options_.workers.size() * options_.particles.size() * granularities;
}

std::string FarmBenchCommand::run_line(const FarmRun& run, std::size_t done) const {
    std::string line = std::to_string(done) + " of " + std::to_string(runs_in_all()) + ": " +
                       std::to_string(run.particles) + " particles on " + std::to_string(run.workers) +
                       (run.workers == 1 ? " worker" : " workers");
    if (sweep_) line += ", " + std::to_string(run.hits_per_message) + " hits a message";
    return line + " took " + std::to_string(run.total_s) + " s";
}

Result<void> FarmBenchCommand::write(const OutputFolder& folder, const std::vector<FarmRun>& runs,
                                     Console& console) const {
    const auto rows = rows_of(runs);
    std::vector<std::pair<std::string, std::string>> files{{"bench.csv", csv_text(runs)},
                                                           {"bench.json", json_text(document(runs, rows))}};
    for (const auto& [name, chart] : charts_of(rows)) files.emplace_back(name + ".svg", svg_text(chart));
    console.result(table(rows));
    for (const auto& [name, text] : files) {
        if (auto written = write_file(folder.path() / name, text); !written) return written;
        console.result("wrote " + (folder.path() / name).string());
    }
    return {};
}

/// What their processes read.
Result<void> FarmBenchCommand::prepare_paced(const CompiledScene& scene, const std::filesystem::path& folder) {
    paced_.scene_file = folder / "scene.lfscene";
    paced_.stored_file = folder / "stored";
    if (auto written = write_file(paced_.scene_file, scene.bytes); !written) return written;
    const auto results = worker::PacedResults::make(scene.bytes, options_.job, paced_.stored_file, options_.isa);
    if (!results) return results.error();
    options_.paced = paced_;
    return {};
}

Result<void> FarmBenchCommand::execute(Console& console) {
    if (auto checked = check_options(); !checked) return checked;
    auto farms = TemporaryFolder::make();
    if (!farms) return farms.error();
    auto folder = OutputFolder::open(output_);
    if (!folder) return folder.error();
    const StopSignals signals([&] {
        farms->remove();
        folder->sweep();
    });
    const auto scene = read_bench_scene(app_, input_, console);
    if (!scene) return scene.error();
    if (paced_.particles_per_s > 0)
        if (auto prepared = prepare_paced(*scene, farms->path()); !prepared) return prepared;
    std::size_t done = 0;
    const auto runs = bench_farm(options_, scene->bytes, farms->path(), [&](const FarmRun& run) {
        const std::string line = run_line(run, ++done);
        done < runs_in_all() ? console.progress(line) : console.end_progress(line);
    });
    if (!runs) return runs.error();
    return write(*folder, *runs, console);
}

}  // namespace

std::unique_ptr<Command> make_farm_bench_command(CLI::App& bench) { return std::make_unique<FarmBenchCommand>(bench); }

}  // namespace lumenfarm
