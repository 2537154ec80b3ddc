#include "cli/farm_client.h"

#include "cli/job_text.h"
#include "cli/number.h"
#include "common/net/address.h"

#include <unistd.h>

#include <array>
#include <utility>

namespace lumenfarm {
namespace {

constexpr double look_seconds = 0.25;  // between two looks at a job

std::string client_name() {
    std::array<char, 256> host{};
    if (::gethostname(host.data(), host.size() - 1) != 0) return "lumenfarm";
    return host.data();
}

}  // namespace

Result<net::BlockingClient> connect_to_farm(const FarmOptions& farm) {
    const auto address = net::HostPort::parse(farm.master);
    if (!address) return bad_input("--master: " + address.error().sentence);
    if (address->port == 0) return bad_input("--master: '" + farm.master + "' has port 0, where nobody listens");
    auto client = net::BlockingClient::connect(*address, client_name());
    if (!client) return failed("no master: " + client.error().sentence + " (--master HOST:PORT names another)");
    return client;
}

Result<std::uint64_t> parse_job(const std::string& text) {
    const auto job = parse_count(text);
    if (!job || *job == 0) return bad_input("'" + text + "' is not a job's number; 'lumenfarm status' lists the jobs");
    return *job;
}

Result<wire::JobStatus> ask_status(net::BlockingClient& client, std::uint64_t job) {
    auto reply = client.ask_for<wire::StatusReply>(wire::StatusRequest(job));
    if (!reply) return reply.error();
    if (reply->jobs.size() != 1) return failed("the master does not say how job " + std::to_string(job) + " is");
    return std::move(reply->jobs.front());
}

Result<wire::JobStatus> watch_job(net::BlockingClient& client, std::uint64_t job, Console& console) {
    for (;;) {
        auto status = ask_status(client, job);
        if (!status) return status;
        if (wire::is_over(status->state)) {
            console.end_progress(progress_line(*status));
            return status;
        }
        console.progress(progress_line(*status));
        if (auto alive = client.idle(look_seconds); !alive) return alive.error();
    }
}

Result<void> outcome(const wire::JobStatus& job) {
    const std::string name = "job " + std::to_string(job.job);
    if (job.state == wire::JobState::failed) return failed(name + " failed: " + job.sentence);
    if (job.state == wire::JobState::cancelled)
        return interrupted(name + " was cancelled after " + std::to_string(job.committed) + " of " +
                           std::to_string(job.particles) + " particles");
    return {};
}

}  // namespace lumenfarm
