#include "master/master_core.h"

#include <algorithm>
#include <utility>

/// The master's core: what submitters ask for.
namespace lumenfarm {

using wire::RefusalReason;

void MasterCore::refuse(SessionId session, std::uint64_t request_id, RefusalReason reason, std::string sentence) {
    counts_.refused_requests.count(reason);
    send(session, wire::Refusal(reason, std::move(sentence)), request_id);
}

JobRecord* MasterCore::find_key(std::uint64_t key) {
    for (auto& [id, job] : jobs_)
        if (key != 0 && job.record.key == key) return &job.record;
    return nullptr;
}

void MasterCore::on(SessionId session, std::uint64_t request_id, wire::Submit submit, double now_s) {
    if (const JobRecord* known = find_key(submit.key))
        return send(session, wire::SubmitReply(known->id(), {}), request_id);
    if (const auto good = validate(submit.spec); !good)
        return refuse(session, request_id, RefusalReason::bad_request, good.error().sentence);
    if (jobs_.size() >= limits::jobs_max || admissions_.size() >= limits::admissions_max)
        return refuse(session, request_id, RefusalReason::full, "this master takes no more jobs now");
    Admit admit;
    admit.session = session;
    admit.request_id = request_id;
    admit.record.key = submit.key;
    admit.record.spec = submit.spec;
    admit.record.scene_bytes = submit.scene.total_bytes;
    wire::JobStatus& status = admit.record.status;
    status.name = submit.spec.name.substr(0, limits::peer_name_bytes_max);
    status.priority = submit.spec.priority;
    status.scene = submit.scene.file;
    status.packing = submit.spec.packing;
    status.particles = submit.spec.particles;
    status.created_unix_seconds = unix_seconds(now_s);
    admit.submit = std::move(submit);
    admissions_.push_back(std::move(admit));
    if (admissions_.size() == 1) admit_next();
}

void MasterCore::admit_next() {
    if (stopping_) return admissions_.clear();
    for (; !admissions_.empty(); admissions_.pop_front()) {
        Admit& next = admissions_.front();
        // the same may have been asked for again while it was on its way
        if (const JobRecord* known = find_key(next.record.key)) {
            send(next.session, wire::SubmitReply(known->id(), {}), next.request_id);
            continue;
        }
        next.record.status.job = next_job_;
        return effects_.push_back(next);
    }
}

Effects MasterCore::on_admitted(const Admit& admit, const Result<std::vector<std::uint32_t>>& missing, double now_s) {
    const auto [session, request_id] = std::pair(admit.session, admit.request_id);
    if (!missing) {
        const bool bad = missing.error().code == ErrorCode::bad_input;
        refuse(session, request_id, bad ? RefusalReason::bad_request : RefusalReason::failed, missing.error().sentence);
    } else if (!missing->empty()) {
        send(session, wire::SubmitReply(0, *missing), request_id);
    } else {
        const JobId id = next_job_++;
        Job job;
        job.record = admit.record;
        jobs_.emplace(id, std::move(job));
        send(session, wire::SubmitReply(id, {}), request_id);
    }
    admissions_.pop_front();
    admit_next();
    return settle_and_take(now_s);
}

void MasterCore::on(SessionId session, std::uint64_t request_id, const wire::StatusRequest& request, double now_s) {
    std::vector<wire::JobStatus> listed;
    if (request.job) {
        const auto one = status(*request.job, now_s);
        if (!one)
            return refuse(session, request_id, RefusalReason::no_such_job,
                          "there is no job " + std::to_string(*request.job));
        listed.push_back(*one);
    } else {
        for (auto it = jobs_.rbegin(); it != jobs_.rend() && listed.size() < limits::jobs_listed_max; ++it)
            listed.push_back(status_of(it->second, now_s));
    }
    auto reply = request.job ? wire::StatusReply(std::move(listed))
                             : wire::StatusReply(std::move(listed), counts_.listed(), counts_.traffic);
    send(session, std::move(reply), request_id);
}

void MasterCore::on(SessionId session, std::uint64_t request_id, const wire::WorkersRequest&, double now_s) {
    send(session, wire::WorkersReply(workers(now_s)), request_id);
}

void MasterCore::on(SessionId session, std::uint64_t request_id, const wire::FetchRequest& request, double) {
    const JobRecord* job = record(request.job);
    const std::string name = "job " + std::to_string(request.job);
    if (!job) return refuse(session, request_id, RefusalReason::no_such_job, "there is no " + name);
    if (!job->over()) return refuse(session, request_id, RefusalReason::not_ready, name + " has no result yet");
    if (!job->has_solution)
        return refuse(session, request_id, RefusalReason::no_such_file,
                      name + " ended without a result" +
                          (job->status.sentence.empty() ? std::string() : ": " + job->status.sentence));
    send(session, wire::FetchReply(job->id(), job->status.scene, job->solution_file, job->complete), request_id);
}

}  // namespace lumenfarm
