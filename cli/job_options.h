#pragma once

#include "common/scene/job_spec.h"

#include <CLI/CLI.hpp>

namespace lumenfarm {

/// The job options of design section 14, for `run` and `submit`. Ranges are checked by validate(spec) afterwards.
void declare_job_options(CLI::App& app, JobSpec& spec);

/// Those of them that the path of a particle depends on.
void declare_path_options(CLI::App& app, JobSpec& spec);
void declare_texel_option(CLI::App& app, JobSpec& spec);
void declare_packing_option(CLI::App& app, JobSpec& spec);
/// Those that only say how the farm does it.
void declare_way_options(CLI::App& app, JobSpec& spec);

}  // namespace lumenfarm
