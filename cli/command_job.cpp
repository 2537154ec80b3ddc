#include "cli/job_command.h"
#include "cli/job_text.h"
#include "cli/options.h"
#include "cli/output_folder.h"
#include "cli/products/json_text.h"
#include "common/net/file_transfer.h"
#include "common/solution/run_folder.h"
#include "common/support/file.h"
#include "common/support/limits.h"

/// `watch`, `why` and `fetch`: what one job of the farm does and has.
namespace lumenfarm {
namespace {

class WatchCommand : public JobCommand {
public:
    WatchCommand(CLI::App& app, const FarmOptions& farm)
        : JobCommand(app, farm, "watch", "Follow a job until it is over") {
        flag_option(app_, "--json", json_, "Print how it ended as one JSON document");
    }

private:
    Result<void> ask(net::BlockingClient& client, std::uint64_t job, Console& console) override {
        const auto status = watch_job(client, job, console);
        if (!status) return status.error();
        if (json_)
            console.result(json_text(job_document(*status)));
        else if (status->digest)
            console.result("digest " + status->digest->hex());
        return outcome(*status);
    }

    bool json_ = false;
};

class WhyCommand : public JobCommand {
public:
    WhyCommand(CLI::App& app, const FarmOptions& farm)
        : JobCommand(app, farm, "why", "Say in one sentence what a job waits for, or how it ended") {}

private:
    Result<void> ask(net::BlockingClient& client, std::uint64_t job, Console& console) override {
        const auto status = ask_status(client, job);
        if (!status) return status.error();
        console.result(status->sentence.empty() ? progress_line(*status) : status->sentence);
        return {};
    }
};

class FetchCommand : public JobCommand {
public:
    FetchCommand(CLI::App& app, const FarmOptions& farm)
        : JobCommand(app, farm, "fetch", "Copy a finished job's solution and scene to this computer") {
        text_option(app_, "-o,--output", output_, "Folder for the two files")->type_name("DIR")->required();
    }

private:
    Result<void> prepare() override {
        auto folder = OutputFolder::open(output_);
        if (!folder) return folder.error();
        folder_.emplace(std::move(*folder));
        return {};
    }

    Result<void> ask(net::BlockingClient& client, std::uint64_t job, Console& console) override {
        const auto files = client.ask_for<wire::FetchReply>(wire::FetchRequest(job));
        if (!files) return files.error();
        const auto scene = net::fetch_file(client, files->scene, limits::scene_bytes_max);
        if (!scene) return scene.error();
        const auto solution = net::fetch_file(client, files->solution_file, limits::solution_bytes_max);
        if (!solution) return solution.error();
        if (auto written = write_file(folder_->path() / scene_file_name, *scene); !written) return written;
        if (auto written = write_file(folder_->path() / solution_file_name, *solution); !written) return written;
        return report(job, files->complete, console);
    }

    Result<void> report(std::uint64_t job, bool complete, Console& console) const {
        const auto run = load_run(folder_->path());
        if (!run) return run.error();
        if (!complete)
            console.note("lumenfarm: warning: job " + std::to_string(job) +
                         " ended early; this is the light of the particles that were done");
        console.result("digest " + solution_digest(run->solution).hex());
        for (const char* name : {solution_file_name, scene_file_name})
            console.result("wrote " + (folder_->path() / name).string());
        return {};
    }

    std::string output_;
    std::optional<OutputFolder> folder_;
};

}  // namespace

std::unique_ptr<Command> make_watch_command(CLI::App& app, const FarmOptions& farm) {
    return std::make_unique<WatchCommand>(app, farm);
}

std::unique_ptr<Command> make_why_command(CLI::App& app, const FarmOptions& farm) {
    return std::make_unique<WhyCommand>(app, farm);
}

std::unique_ptr<Command> make_fetch_command(CLI::App& app, const FarmOptions& farm) {
    return std::make_unique<FetchCommand>(app, farm);
}

}  // namespace lumenfarm
