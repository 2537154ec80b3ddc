#pragma once

#include "relay/effects.h"

#include <cstddef>
#include <functional>
#include <vector>

namespace lumenfarm::relay {

using ReadFile = std::function<Result<std::vector<std::byte>>(const Digest&)>;

/// Answers PrepareLent from files that were kept: the job as the master above has it, of which nothing is lent yet; or
/// what its plan names. Errors: bad_input (a damaged plan or scene, or one of another job), those of `read`.
Result<Preparation> prepare_lent(const PrepareLent& effect, const ReadFile& read);

}  // namespace lumenfarm::relay
