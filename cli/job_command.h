#pragma once

#include "cli/commands.h"
#include "cli/farm_client.h"

#include <cstdint>
#include <string>

namespace lumenfarm {

/// A command about one JOB of the farm.
class JobCommand : public Command {
public:
    Result<void> execute(Console& console) override {
        const auto job = parse_job(job_);
        if (!job) return job.error();
        if (auto ready = prepare(); !ready) return ready;
        auto client = connect_to_farm(farm_);
        if (!client) return client.error();
        return ask(*client, *job, console);
    }

protected:
    JobCommand(CLI::App& app, const FarmOptions& farm, const std::string& name, const std::string& help)
        : Command(app, name, help), farm_(farm) {
        app_.add_option("JOB", job_, "The job's number")->type_name("")->required();
    }
    /// What must hold before the master is asked.
    virtual Result<void> prepare() { return {}; }
    virtual Result<void> ask(net::BlockingClient& client, std::uint64_t job, Console& console) = 0;

private:
    const FarmOptions& farm_;
    std::string job_;
};

}  // namespace lumenfarm
