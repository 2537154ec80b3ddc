#pragma once

#include "common/solution/interval_set.h"
#include "common/solution/solution.h"

#include <vector>

namespace lumenfarm::testing {

/// The result that a job on small_scene() must have whose committed particles, by light, are these: each traced once
/// by the tracer that its farm has, by nobody's leave.
Solution reference_solution(const JobSpec& spec, const std::vector<IntervalSet>& committed);

}  // namespace lumenfarm::testing
