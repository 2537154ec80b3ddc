#include "worker/discard.h"

namespace lumenfarm::worker {

std::string_view name_of(Discard reason) {
    switch (reason) {
        case Discard::result_refused: return "result_refused";
        case Discard::result_of_gone_job: return "result_of_gone_job";
        case Discard::result_undelivered: return "result_undelivered";
        case Discard::set_of_gone_job: return "set_of_gone_job";
        case Discard::set_outlived: return "set_outlived";
        case Discard::set_not_traceable: return "set_not_traceable";
        case Discard::memory_too_small: return "memory_too_small";
        case Discard::unexpected_message: return "unexpected_message";
        case Discard::damaged_chunk: return "damaged_chunk";
        case Discard::scene_not_fetched: return "scene_not_fetched";
        case Discard::scene_not_cached: return "scene_not_cached";
        case Discard::cached_scene_damaged: return "cached_scene_damaged";
        case Discard::cached_scene_displaced: return "cached_scene_displaced";
        case Discard::part_given_up: return "part_given_up";
    }
    return "unknown";
}

void WorkerCounts::count(const net::Closed& closed) {
    closes.count(closed.reason);
    if (closed.wire) refused_frames.count(*closed.wire);
}

std::string WorkerCounts::text() const {
    std::string text;
    const auto add = [&](const char* group, const std::string& counts) {
        if (!counts.empty()) text += (text.empty() ? "" : "; ") + std::string(group) + ": " + counts;
    };
    add("answers to results", verdicts.text());
    add("discarded", discards.text());
    add("connections closed", closes.text());
    add("messages refused", refused_frames.text());
    return text;
}

}  // namespace lumenfarm::worker
