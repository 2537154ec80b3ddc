#pragma once

#include "proto/messages_client.h"

#include <boost/json/object.hpp>

#include <span>
#include <string>
#include <string_view>

/// Jobs and workers as people and scripts see them.
namespace lumenfarm {

/// "cornell: 12.3M of 20M particles (61 %), 1.21M/s, 6 s left"
std::string progress_line(const wire::JobStatus& job);

/// A line a job, with a head line.
std::string jobs_table(std::span<const wire::JobStatus> jobs);
/// Everything about one job.
std::string job_details(const wire::JobStatus& job);
/// What the master has refused, closed and discarded: a line a group, without what has not come up; empty when nothing
/// has.
std::string counts_text(std::span<const wire::ReasonCount> counts);
/// What came from workers and went to them; empty when nothing did.
std::string traffic_text(const wire::Traffic& traffic);
std::string workers_table(std::span<const wire::WorkerStatus> workers);

boost::json::object job_document(const wire::JobStatus& job);
/// {"group": {"reason": count ...} ...}, all reasons.
boost::json::object counts_document(std::span<const wire::ReasonCount> counts);
boost::json::object traffic_document(const wire::Traffic& traffic);
boost::json::object worker_document(const wire::WorkerStatus& worker);

/// "41 s", "3 min 20 s", "2 h 5 min".
std::string duration_text(double seconds);

}  // namespace lumenfarm
