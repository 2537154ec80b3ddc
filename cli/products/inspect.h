#pragma once

#include "common/solution/run_folder.h"

#include <boost/json/object.hpp>

#include <string>
#include <vector>

/// What `inspect` shows of a result.
namespace lumenfarm {

/// The document of design section 14 and more: `surfaces` hold the light of both sides over the one-sided area, and
/// each side in `front` and `back`. Errors that nothing is known of are null.
boost::json::object inspect_document(const LoadedRun& run);

/// The same for people: one line a light and a surface.
std::string inspect_table(const LoadedRun& run);

/// report.json of a run: the document, the job's options and the pictures' names.
boost::json::object report_document(const LoadedRun& run, const std::vector<std::string>& pictures);

}  // namespace lumenfarm
