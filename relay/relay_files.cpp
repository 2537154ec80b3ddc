#include "relay/relay_core.h"

#include <algorithm>
#include <utility>

/// The relay's core: files that it and its workers need are fetched once from the master above, and kept while a job
/// needs them.
namespace lumenfarm::relay {

using worker::Discard;

std::optional<std::uint64_t> RelayCore::bytes_of(const Digest& file) const {
    for (const auto& [id, job] : jobs_)
        if (const auto found = job.files.find(file); found != job.files.end()) return found->second;
    return std::nullopt;
}

void RelayCore::need(Job& job, const Digest& file) {
    job.phase = Phase::fetching;
    job.needs = file;
    kept_.contains(file) ? prepare(job) : want(file);
}

void RelayCore::want(const Digest& file) {
    const bool on_its_way = keeping_.contains(file) || (fetch_ && fetch_->scene() == file) ||
                            std::find(wanted_.begin(), wanted_.end(), file) != wanted_.end();
    if (on_its_way) return;
    wanted_.push_back(file);
    fetch_next();
}

void RelayCore::prepare(Job& job) {
    job.phase = Phase::preparing;
    effects_.push_back(PrepareLent{job.info, job.needs != job.info.scene});
}

/// A request for a file that is on its way waits; one for a file that no job needs is refused by the shell.
void RelayCore::serve(const Request& request) {
    const Digest& file = request.file;
    if (kept_.contains(file) || !bytes_of(file)) return effects_.push_back(request);
    if (requests_.size() >= 2 * limits::sessions_max)
        return refuse(request, wire::RefusalReason::full, "too many wait for files already");
    requests_.push_back(request);
    want(file);
}

void RelayCore::refuse(const Request& request, wire::RefusalReason reason, const std::string& why) {
    effects_.push_back(Send{request.session, wire::Refusal(reason, why, request.file), request.request_id});
}

void RelayCore::fetch_next() {
    while (!fetch_ && !wanted_.empty()) {
        const Digest file = wanted_.front();
        wanted_.pop_front();
        if (const auto bytes = bytes_of(file)) {
            fetch_.emplace(file, *bytes);
            if (!welcome_) return;
            for (wire::Message& request : fetch_->begin_session()) send(std::move(request));
        } else {
            refuse_all(file, "no job needs it any more");
        }
    }
}

void RelayCore::take_requests(const Result<std::vector<wire::Message>>& requests) {
    if (fetch_->dropped()) count(*fetch_->dropped(), 1, "of file " + fetch_->scene().hex());
    if (!requests) return fail_fetch(fetch_->scene(), requests.error().sentence);
    for (const wire::Message& request : *requests) send(request);
    const auto bytes = fetch_->complete();
    if (!bytes) return;
    keeping_.insert(fetch_->scene());
    effects_.push_back(KeepFile{fetch_->scene(), bytes});
    fetch_.reset();
    fetch_next();
}

Effects RelayCore::on_file_kept(const Digest& file, const Result<void>& kept, double now_s) {
    keeping_.erase(file);
    if (!kept) {
        fail_fetch(file, kept.error().sentence);
    } else if (!bytes_of(file)) {
        effects_.push_back(RemoveFile{file});
        refuse_all(file, "no job needs it any more");
    } else {
        kept_.insert(file);
        for (auto& [id, job] : jobs_)
            if (job.phase == Phase::fetching && job.needs == file) prepare(job);
        const auto answered = std::partition(requests_.begin(), requests_.end(),
                                             [&](const Request& request) { return request.file != file; });
        effects_.insert(effects_.end(), answered, requests_.end());
        requests_.erase(answered, requests_.end());
    }
    return settle_and_take(now_s);
}

/// Whoever waits for the file hears that it does not come.
void RelayCore::fail_fetch(Digest file, const std::string& why) {
    count(Discard::scene_not_fetched, 1, file.hex() + ": " + why);
    if (fetch_ && fetch_->scene() == file) fetch_.reset();
    for (auto& [id, job] : jobs_)
        if (job.phase == Phase::fetching && job.needs == file) fail_job(job, wire::ReturnReason::no_scene);
    refuse_all(file, why);
    fetch_next();
}

void RelayCore::refuse_all(const Digest& file, const std::string& why) {
    std::erase_if(requests_, [&](const Request& request) {
        if (request.file != file) return false;
        refuse(request, wire::RefusalReason::no_such_file, why);
        return true;
    });
}

}  // namespace lumenfarm::relay
