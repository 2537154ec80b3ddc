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
std::string workers_table(std::span<const wire::WorkerStatus> workers);

boost::json::object job_document(const wire::JobStatus& job);
boost::json::object worker_document(const wire::WorkerStatus& worker);

/// "41 s", "3 min 20 s", "2 h 5 min".
std::string duration_text(double seconds);

}  // namespace lumenfarm
