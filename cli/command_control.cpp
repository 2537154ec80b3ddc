#include "cli/job_command.h"
#include "cli/options.h"

#include <string_view>

/// `pause`, `resume`, `cancel`, `extend` and `remove`: what is done to one job.
namespace lumenfarm {
namespace {

/// What the job is when the master has done it.
std::string_view participle(wire::JobAction action) {
    switch (action) {
        case wire::JobAction::pause: return "paused";
        case wire::JobAction::resume: return "resumed";
        case wire::JobAction::cancel: return "cancelled";
        case wire::JobAction::extend: return "extended";
        case wire::JobAction::remove: return "removed";
    }
    return "?";
}

class ControlCommand : public JobCommand {
public:
    ControlCommand(CLI::App& app, const FarmOptions& farm, wire::JobAction action, const std::string& name,
                   const std::string& help)
        : JobCommand(app, farm, name, help), action_(action) {
        if (action != wire::JobAction::extend) return;
        count_option(app_, "--particles", particles_, "How many the job has in all from now on")->required();
    }

private:
    Result<void> prepare() override {
        if (action_ == wire::JobAction::extend && particles_ == 0)
            return bad_input("--particles is 0; a job is extended to more particles than it has");
        return {};
    }

    Result<void> ask(net::BlockingClient& client, std::uint64_t job, Console& console) override {
        const auto reply = client.ask_for<wire::ControlReply>(wire::ControlRequest(job, action_, particles_));
        if (!reply) return reply.error();
        const bool was_over = action_ == wire::JobAction::cancel && wire::is_over(reply->state) &&
                              reply->state != wire::JobState::cancelled;
        console.result(
            "job " + std::to_string(job) + " is " +
            (was_over ? std::string(wire::name_of(reply->state)) + " already" : std::string(participle(action_))));
        return {};
    }

    wire::JobAction action_;
    std::uint64_t particles_ = 0;
};

}  // namespace

std::vector<std::unique_ptr<Command>> make_control_commands(CLI::App& app, const FarmOptions& farm) {
    using enum wire::JobAction;
    std::vector<std::unique_ptr<Command>> commands;
    const auto add = [&](wire::JobAction action, const std::string& name, const std::string& help) {
        commands.push_back(std::make_unique<ControlCommand>(app, farm, action, name, help));
    };
    add(pause, "pause", "Give a job no more work for now; what is done is kept");
    add(resume, "resume", "Let a paused job go on");
    add(cancel, "cancel", "End a job now; what is done is kept and can be fetched");
    add(extend, "extend", "Give a job more particles; one that is over goes on from its result");
    add(remove, "remove", "Forget a job that is over, and its result");
    return commands;
}

}  // namespace lumenfarm
