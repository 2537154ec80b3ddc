#pragma once

#include "common/support/result.h"
#include "common/transport/part_tracer.h"
#include "common/transport/tracer.h"
#include "worker/job_context.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace lumenfarm {

/// What particles are traced with: in one subspace, or in the whole scene. One of the two.
struct Piece {
    std::shared_ptr<const PartTracer> part;
    std::shared_ptr<const TracerScene> whole;
};

/// From the bytes of a subspace's part, or, for subspace `none`, of the compiled scene. Keeps the plan. `isa` as in
/// TracerScene::make. Errors: bad_input (damaged, or not of the plan), failed (no memory).
Result<Piece> make_piece(std::uint32_t subspace, std::span<const std::byte> bytes,
                         const std::shared_ptr<const PlanContext>& plan, const std::string& isa);

}  // namespace lumenfarm
