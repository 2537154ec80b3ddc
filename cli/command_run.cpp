#include "cli/commands.h"
#include "cli/embedded_farm.h"
#include "cli/job_options.h"
#include "cli/job_text.h"
#include "cli/options.h"
#include "cli/output_folder.h"
#include "cli/products/inspect.h"
#include "cli/products/json_text.h"
#include "cli/products/pictures.h"
#include "cli/scene_input.h"
#include "cli/stop_signals.h"
#include "cli/temporary_folder.h"
#include "common/solution/run_folder.h"
#include "common/support/file.h"
#include "common/support/limits.h"
#include "common/transport/tracer.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <thread>
#include <utility>

/// `run`: a whole farm in this process, then the products.
namespace lumenfarm {
namespace {

constexpr double look_seconds = 0.1;  // between two looks at the job
constexpr std::uint32_t workers_max = 64;

class RunCommand : public Command {
public:
    explicit RunCommand(CLI::App& app);
    Result<void> execute(Console& console) override;

private:
    Result<void> check_options();
    EmbeddedFarm::Options farm_options() const;
    Result<void> trace(const CompiledScene& scene, const OutputFolder& folder, const TemporaryFolder& storage,
                       StopSignals& signals, Console& console);
    Result<wire::JobStatus> see_through(EmbeddedFarm& farm, JobId job, StopSignals& signals, Console& console);
    Result<void> take_home(EmbeddedFarm& farm, JobId job, const OutputFolder& folder) const;
    Result<void> make_products(const OutputFolder& folder, bool complete, Console& console) const;

    SceneOptions scene_;
    JobSpec spec_;
    std::string output_;
    std::string isa_;
    std::uint32_t workers_ = 1;
    std::uint32_t threads_ = 0;
};

RunCommand::RunCommand(CLI::App& app)
    : Command(app, "run", "Compute a scene's light on this computer: solution, report and pictures") {
    declare_scene_options(app_, scene_);
    text_option(app_, "-o,--output", output_, "Folder for the results")->type_name("DIR")->required();
    count_option(app_, "--workers", workers_, "Workers to start");
    count_option(app_, "--threads", threads_, "Threads of each worker; 0 shares all cores out");
    choice_option<std::string>(app_, "--isa", isa_,
                               {{"auto", ""}, {"sse4.2", "sse4.2"}, {"avx2", "avx2"}, {"avx512", "avx512"}},
                               "Instruction set of the ray queries; what comes out is the same");
    declare_job_options(app_, spec_);
}

Result<void> RunCommand::check_options() {
    if (workers_ < 1 || workers_ > workers_max)
        return bad_input("workers is " + std::to_string(workers_) + "; it must be from 1 to " +
                         std::to_string(workers_max));
    if (threads_ > limits::threads_per_worker_max)
        return bad_input("threads is " + std::to_string(threads_) + "; it must be from 0 to " +
                         std::to_string(limits::threads_per_worker_max));
    if (spec_.name.empty()) spec_.name = scene_title(scene_);
    return validate(spec_);
}

EmbeddedFarm::Options RunCommand::farm_options() const {
    const std::uint32_t cores = std::max(1u, std::thread::hardware_concurrency());
    return {workers_, threads_ != 0 ? threads_ : std::max(1u, cores / workers_), isa_};
}

Result<void> RunCommand::execute(Console& console) {
    if (auto checked = check_options(); !checked) return checked;
    auto storage = TemporaryFolder::make();
    if (!storage) return storage.error();
    auto folder = OutputFolder::open(output_);
    if (!folder) return folder.error();
    StopSignals signals([&] {
        storage->remove();
        folder->sweep();
    });
    auto scene = read_scene(scene_, console);
    if (!scene) return scene.error();
    // the farm's own log would disturb the progress line; what a user must know comes as an error
    spdlog::set_default_logger(spdlog::stderr_color_mt("farm"));
    spdlog::set_level(spdlog::level::err);
    return trace(*scene, *folder, *storage, signals, console);
}

Result<void> RunCommand::trace(const CompiledScene& scene, const OutputFolder& folder, const TemporaryFolder& storage,
                               StopSignals& signals, Console& console) {
    auto farm = EmbeddedFarm::start(farm_options(), storage);
    if (!farm) return farm.error();
    signals.keep_what_is_done();
    const auto job = (*farm)->master().submit(spec_, scene.bytes);
    if (!job) return job.error();
    const auto status = see_through(**farm, *job, signals, console);
    if (!status) return status.error();
    if (auto taken = take_home(**farm, *job, folder); !taken) return taken;
    farm->reset();
    signals.end_at_once();
    const bool complete = status->state == wire::JobState::done;
    if (auto made = make_products(folder, complete, console); !made) return made;
    if (complete) return {};
    if (auto told = console.finish(); !told) return told;
    return interrupted("interrupted after " + std::to_string(status->committed) + " of " +
                       std::to_string(status->particles) + " particles; the light of these is kept in '" + output_ +
                       "'");
}

Result<wire::JobStatus> RunCommand::see_through(EmbeddedFarm& farm, JobId job, StopSignals& signals, Console& console) {
    bool cancelled = false;
    for (;;) {
        const auto status = farm.master().wait(job, look_seconds);
        if (!status) return status.error();
        if (wire::is_over(status->state)) {
            console.end_progress(progress_line(*status));
            if (status->state == wire::JobState::failed) return failed(status->sentence);
            return *status;
        }
        console.progress(progress_line(*status));
        if (auto working = farm.check_workers(); !working) return working.error();
        if (signals.asked() && !std::exchange(cancelled, true)) {
            console.note("lumenfarm: stopping; once more stops at once and keeps nothing");
            farm.master().cancel(job);
        }
    }
}

/// The files come out of the storage as they are: what is written is what the farm has made.
Result<void> RunCommand::take_home(EmbeddedFarm& farm, JobId job, const OutputFolder& folder) const {
    const auto files = farm.master().files(job);
    if (!files) return files.error();
    const auto copy = [&](const std::filesystem::path& from, const char* name,
                          std::uint64_t bytes_max) -> Result<void> {
        const auto bytes = read_file(from, bytes_max);
        if (!bytes) return bytes.error();
        return write_file(folder.path() / name, *bytes);
    };
    if (auto copied = copy(files->scene, scene_file_name, limits::scene_bytes_max); !copied) return copied;
    return copy(files->solution, solution_file_name, limits::solution_bytes_max);
}

Result<void> RunCommand::make_products(const OutputFolder& folder, bool complete, Console& console) const {
    const auto run = load_run(folder.path());
    if (!run) return run.error();
    console.result("digest " + solution_digest(run->solution).hex());
    const auto wrote = [&](const std::string& name) { console.result("wrote " + (folder.path() / name).string()); };
    // before the pictures, so that it is there when somebody does not wait for them
    const auto report = write_file(folder.path() / "report.json", json_text(report_document(*run, {})));
    if (!report) return report;
    for (const char* name : {solution_file_name, scene_file_name, "report.json"}) wrote(name);
    if (!complete) return {};
    console.progress("making pictures");
    auto tracer = TracerScene::make(run->scene, isa_);
    if (!tracer) return tracer.error();
    const auto pictures = write_products(*run, **tracer, folder.path(), {});
    if (!pictures) return pictures.error();
    for (const auto& picture : *pictures) wrote(picture);
    return {};
}

}  // namespace

std::unique_ptr<Command> make_run_command(CLI::App& app) { return std::make_unique<RunCommand>(app); }

}  // namespace lumenfarm
