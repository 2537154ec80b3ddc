#include "cli/commands.h"
#include "cli/farm_client.h"
#include "cli/job_options.h"
#include "cli/options.h"
#include "cli/scene_input.h"
#include "common/net/file_transfer.h"

#include <random>

/// `submit`: sends a scene and a job to the farm.
namespace lumenfarm {
namespace {

std::uint64_t random_key() {
    std::random_device device;
    return std::uint64_t{device()} << 32 | device();
}

class SubmitCommand : public Command {
public:
    SubmitCommand(CLI::App& app, const FarmOptions& farm)
        : Command(app, "submit", "Send a scene to a farm; prints the job's number"), farm_(farm) {
        declare_scene_options(app_, scene_);
        flag_option(app_, "--wait", wait_, "Wait until the job is over, and print the digest of its result");
        declare_job_options(app_, spec_);
    }

    Result<void> execute(Console& console) override {
        if (spec_.name.empty()) spec_.name = scene_title(scene_);
        if (auto checked = validate(spec_); !checked) return checked;
        auto scene = read_scene(scene_, console);
        if (!scene) return scene.error();
        auto client = connect_to_farm(farm_);
        if (!client) return client.error();
        const auto job = net::submit_job(*client, random_key(), spec_, scene->bytes);
        if (!job) return job.error();
        console.result(std::to_string(*job));
        return wait_ ? see_through(*client, *job, console) : Result<void>();
    }

private:
    static Result<void> see_through(net::BlockingClient& client, std::uint64_t job, Console& console) {
        if (auto told = console.finish(); !told) return told;
        const auto status = watch_job(client, job, console);
        if (!status) return status.error();
        if (status->digest) console.result("digest " + status->digest->hex());
        return outcome(*status);
    }

    const FarmOptions& farm_;
    SceneOptions scene_;
    JobSpec spec_;
    bool wait_ = false;
};

}  // namespace

std::unique_ptr<Command> make_submit_command(CLI::App& app, const FarmOptions& farm) {
    return std::make_unique<SubmitCommand>(app, farm);
}

}  // namespace lumenfarm
