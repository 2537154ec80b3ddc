#include "cli/commands.h"
#include "cli/farm_client.h"
#include "cli/job_text.h"
#include "cli/options.h"
#include "cli/products/json_text.h"

#include <boost/json.hpp>

/// `status` and `workers`: what the farm does.
namespace lumenfarm {
namespace {

class StatusCommand : public Command {
public:
    StatusCommand(CLI::App& app, const FarmOptions& farm)
        : Command(app, "status", "Show the farm's jobs, or everything about one"), farm_(farm) {
        app_.add_option("JOB", job_, "The job's number")->type_name("");
        flag_option(app_, "--json", json_, "Print one JSON document");
    }

    Result<void> execute(Console& console) override {
        std::optional<std::uint64_t> wanted;
        if (!job_.empty()) {
            const auto job = parse_job(job_);
            if (!job) return job.error();
            wanted = *job;
        }
        auto client = connect_to_farm(farm_);
        if (!client) return client.error();
        const auto reply = client->ask_for<wire::StatusReply>(wire::StatusRequest(wanted));
        if (!reply) return reply.error();
        if (wanted && reply->jobs.empty()) return bad_input("there is no job " + std::to_string(*wanted));
        console.result(wanted ? text_of(reply->jobs.front()) : text_of(*reply));
        return {};
    }

private:
    std::string text_of(const wire::JobStatus& job) const {
        return json_ ? json_text(job_document(job)) : job_details(job);
    }
    std::string text_of(const wire::StatusReply& farm) const {
        if (!json_) {
            const std::string happened = traffic_text(farm.traffic) + counts_text(farm.counts);
            return jobs_table(farm.jobs) + (happened.empty() ? "" : "\nsince the master started\n" + happened);
        }
        boost::json::array list;
        for (const auto& job : farm.jobs) list.push_back(job_document(job));
        return json_text(boost::json::object{{"jobs", std::move(list)},
                                             {"counts", counts_document(farm.counts)},
                                             {"traffic", traffic_document(farm.traffic)}});
    }

    const FarmOptions& farm_;
    std::string job_;
    bool json_ = false;
};

class WorkersCommand : public Command {
public:
    WorkersCommand(CLI::App& app, const FarmOptions& farm)
        : Command(app, "workers", "Show the farm's workers"), farm_(farm) {
        flag_option(app_, "--json", json_, "Print one JSON document");
    }

    Result<void> execute(Console& console) override {
        auto client = connect_to_farm(farm_);
        if (!client) return client.error();
        const auto reply = client->ask_for<wire::WorkersReply>(wire::WorkersRequest());
        if (!reply) return reply.error();
        console.result(text_of(reply->workers));
        return {};
    }

private:
    std::string text_of(const std::vector<wire::WorkerStatus>& workers) const {
        if (!json_) return workers_table(workers);
        boost::json::array list;
        for (const auto& worker : workers) list.push_back(worker_document(worker));
        return json_text(boost::json::object{{"workers", std::move(list)}});
    }

    const FarmOptions& farm_;
    bool json_ = false;
};

}  // namespace

std::unique_ptr<Command> make_status_command(CLI::App& app, const FarmOptions& farm) {
    return std::make_unique<StatusCommand>(app, farm);
}

std::unique_ptr<Command> make_workers_command(CLI::App& app, const FarmOptions& farm) {
    return std::make_unique<WorkersCommand>(app, farm);
}

}  // namespace lumenfarm
