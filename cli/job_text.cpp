#include "cli/job_text.h"

#include "cli/number.h"
#include "cli/products/format_line.h"
#include "common/scene/text.h"

#include <array>
#include <cmath>
#include <ctime>
#include <map>

namespace lumenfarm {
namespace {

namespace json = boost::json;

std::string_view name_of(wire::WorkerState state) {
    switch (state) {
        case wire::WorkerState::idle: return "idle";
        case wire::WorkerState::working: return "working";
    }
    return "?";
}

double fraction(const wire::JobStatus& job) {
    return job.particles == 0 ? 0 : static_cast<double>(job.committed) / static_cast<double>(job.particles);
}

std::string title(const wire::JobStatus& job) {
    return job.name.empty() ? "job " + std::to_string(job.job) : clean_name(job.name);
}

std::string time_text(std::int64_t unix_seconds) {
    const std::time_t time = unix_seconds;
    std::tm local{};
    std::array<char, 64> buffer{};
    if (!localtime_r(&time, &local)) return "-";
    std::strftime(buffer.data(), buffer.size(), "%Y-%m-%d %H:%M:%S", &local);
    return buffer.data();
}

/// `end` is beyond the last particle.
json::array set_aside(const wire::JobStatus& job) {
    json::array ranges;
    for (const ParticleRange& range : job.set_aside)
        ranges.push_back(
            json::object{{"light", range.source}, {"first", range.first}, {"end", range.first + range.count}});
    return ranges;
}

std::string count_of(std::uint64_t count) { return short_count(static_cast<double>(count)); }

}  // namespace

std::string progress_line(const wire::JobStatus& job) {
    if (job.state == wire::JobState::queued) return title(job) + ": queued";
    std::string text = title(job) + ": " + count_of(job.committed) + " of " + count_of(job.particles) +
                       format_line(" particles (%.0f %%)", std::floor(100 * fraction(job)));
    if (job.state == wire::JobState::done) return text + ", done in " + duration_text(job.elapsed_seconds);
    if (job.state != wire::JobState::running) return text + ", " + std::string(wire::name_of(job.state));
    if (job.particles_per_second > 0) text += ", " + short_count(job.particles_per_second) + "/s";
    if (job.eta_seconds) text += ", " + duration_text(*job.eta_seconds) + " left";
    if (job.workers == 0 && job.committed < job.particles) text += ", no worker is at it";
    return text;
}

std::string jobs_table(std::span<const wire::JobStatus> jobs) {
    if (jobs.empty()) return "no jobs\n";
    std::string text = format_line("%6s  %-24s %-10s %9s %9s %6s %10s %12s\n", "job", "name", "state", "particles",
                                   "done", "%", "rate", "time left");
    for (const auto& job : jobs) {
        const std::string rate = job.particles_per_second > 0 ? short_count(job.particles_per_second) + "/s" : "-";
        const std::string left = job.eta_seconds ? duration_text(*job.eta_seconds) : "-";
        text += format_line(
            "%6llu  %-24.24s %-10.10s %9s %9s %6.1f %10s %12s\n", static_cast<unsigned long long>(job.job),
            title(job).c_str(), std::string(wire::name_of(job.state)).c_str(), count_of(job.particles).c_str(),
            count_of(job.committed).c_str(), std::floor(1000 * fraction(job)) / 10, rate.c_str(), left.c_str());
    }
    return text;
}

std::string job_details(const wire::JobStatus& job) {
    std::string text = format_line("job        %llu\n", static_cast<unsigned long long>(job.job));
    const auto add = [&](const char* label, const std::string& value) {
        text += format_line("%-10s ", label) + value + "\n";
    };
    add("name", clean_name(job.name));
    add("state", std::string(wire::name_of(job.state)));
    if (!job.sentence.empty()) add("why", clean_name(job.sentence));
    add("submitted", time_text(job.created_unix_seconds));
    add("priority", std::to_string(job.priority));
    add("particles",
        format_line("%llu of %llu (%.1f %%)", static_cast<unsigned long long>(job.committed),
                    static_cast<unsigned long long>(job.particles), std::floor(1000 * fraction(job)) / 10));
    add("hits", std::to_string(job.hits));
    if (job.particles_per_second > 0) add("rate", short_count(job.particles_per_second) + " particles/s");
    if (job.eta_seconds) add("time left", duration_text(*job.eta_seconds));
    add("time", duration_text(job.elapsed_seconds) + ", " + duration_text(job.trace_seconds) + " of tracing");
    add("workers", std::to_string(job.workers));
    add("packing", std::string(name_of(job.packing)));
    add("scene", job.scene.hex());
    if (job.digest) add("digest", job.digest->hex());
    return text;
}

std::string counts_text(std::span<const wire::ReasonCount> counts) {
    std::map<std::string, std::string> groups;
    for (const auto& each : counts) {
        if (each.count == 0) continue;
        std::string& text = groups[each.group];
        text += (text.empty() ? "" : ", ") + each.reason + " " + std::to_string(each.count);
    }
    std::string text;
    for (const auto& [group, reasons] : groups)
        text += format_line("%-19s ", clean_name(group).c_str()) + clean_name(reasons) + "\n";
    return text;
}

std::string traffic_text(const wire::Traffic& traffic) {
    if (traffic.messages_in == 0) return {};
    const auto part = [](std::uint64_t bytes, std::uint64_t messages) {
        return short_count(static_cast<double>(bytes)) + " bytes in " + count_of(messages) + " messages";
    };
    return format_line("%-19s ", "traffic") + part(traffic.bytes_in, traffic.messages_in) + " from workers, " +
           part(traffic.bytes_out, traffic.messages_out) + " to them\n";
}

std::string workers_table(std::span<const wire::WorkerStatus> workers) {
    if (workers.empty()) return "no workers\n";
    std::string text = format_line("%-24s %-21s %-6s %-9s %7s %-8s %9s %10s %6s %10s\n", "name", "address", "role",
                                   "state", "threads", "isa", "particles", "rate", "job", "connected");
    for (const auto& worker : workers) {
        const std::string job = worker.job == 0 ? "-" : std::to_string(worker.job);
        text +=
            format_line("%-24.24s %-21.21s %-6s %-9s %7u %-8.8s %9s %10s %6s %10s\n", clean_name(worker.name).c_str(),
                        clean_name(worker.address).c_str(), std::string(name_of(worker.role)).c_str(),
                        std::string(name_of(worker.state)).c_str(), worker.threads, clean_name(worker.isa).c_str(),
                        count_of(worker.particles).c_str(), (short_count(worker.particles_per_second) + "/s").c_str(),
                        job.c_str(), duration_text(worker.connected_seconds).c_str());
    }
    return text;
}

json::object job_document(const wire::JobStatus& job) {
    return {{"job", job.job},
            {"name", job.name},
            {"state", wire::name_of(job.state)},
            {"sentence", job.sentence},
            {"priority", job.priority},
            {"scene", job.scene.hex()},
            {"packing", name_of(job.packing)},
            {"particles", job.particles},
            {"committed", job.committed},
            {"leased", job.leased},
            {"hits", job.hits},
            {"workers", job.workers},
            {"particles_per_s", job.particles_per_second},
            {"eta_s", job.eta_seconds ? json::value(*job.eta_seconds) : json::value(nullptr)},
            {"created_unix_s", job.created_unix_seconds},
            {"elapsed_s", job.elapsed_seconds},
            {"trace_s", job.trace_seconds},
            {"leases_expired", job.leases_expired},
            {"leases_returned", job.leases_returned},
            {"results_stale", job.results_stale},
            {"results_invalid", job.results_invalid},
            {"audits", job.audits},
            {"liars", job.liars},
            {"set_aside", set_aside(job)},
            {"digest", job.digest ? json::value(job.digest->hex()) : json::value(nullptr)}};
}

json::object counts_document(std::span<const wire::ReasonCount> counts) {
    json::object groups;
    for (const auto& each : counts) {
        json::value& group = groups[each.group];
        if (!group.is_object()) group.emplace_object();
        group.as_object()[each.reason] = each.count;
    }
    return groups;
}

json::object traffic_document(const wire::Traffic& traffic) {
    return {{"bytes_in", traffic.bytes_in},
            {"bytes_out", traffic.bytes_out},
            {"messages_in", traffic.messages_in},
            {"messages_out", traffic.messages_out}};
}

json::object worker_document(const wire::WorkerStatus& worker) {
    return {{"session", worker.session},
            {"name", worker.name},
            {"address", worker.address},
            {"role", name_of(worker.role)},
            {"state", name_of(worker.state)},
            {"threads", worker.threads},
            {"memory_bytes", worker.memory_bytes},
            {"isa", worker.isa},
            {"job", worker.job == 0 ? json::value(nullptr) : json::value(worker.job)},
            {"leases", worker.leases},
            {"particles", worker.particles},
            {"particles_per_s", worker.particles_per_second},
            {"connected_s", worker.connected_seconds},
            {"silent_s", worker.silent_seconds}};
}

std::string duration_text(double seconds) {
    if (!(seconds >= 0)) return "-";
    if (seconds < 9.95) return format_line("%.1f s", seconds);
    const auto whole = static_cast<long long>(std::llround(std::min(seconds, 1e12)));
    if (whole < 60) return format_line("%lld s", whole);
    if (whole < 3600) return format_line("%lld min %lld s", whole / 60, whole % 60);
    if (whole < 48 * 3600) return format_line("%lld h %lld min", whole / 3600, whole % 3600 / 60);
    return format_line("%lld days", whole / 86400);
}

}  // namespace lumenfarm
