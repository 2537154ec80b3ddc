#pragma once

#include "common/scene/job_spec.h"
#include "common/scene/scene.h"
#include "common/solution/texel_layout.h"
#include "common/support/result.h"
#include "common/transport/tracer.h"
#include "proto/messages.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

/// What a tracing thread needs of a job. Read-only and shared by threads.
namespace lumenfarm {

using JobId = std::uint64_t;

/// A compiled scene made ready for tracing. Jobs of one scene share it.
struct SceneContext {
    Scene scene;
    std::unique_ptr<TracerScene> tracer;  ///< over `scene`
};

struct JobContext {
    JobId job = 0;
    JobSpec spec;  ///< its packing is the one in force
    std::shared_ptr<const SceneContext> scene;
    std::optional<TexelLayout> layout;  ///< packing maps
};

/// Errors: bad_input (damaged scene), failed (no memory for the tracer). `isa` as in TracerScene::make.
Result<std::shared_ptr<const SceneContext>> make_scene_context(std::span<const std::byte> scene_bytes,
                                                               const std::string& isa, const TracerMaker& make_tracer);

/// Errors: bad_input (a spec that can't be, too many texels).
Result<std::shared_ptr<const JobContext>> make_job_context(const wire::JobInfo& info,
                                                           std::shared_ptr<const SceneContext> scene);

}  // namespace lumenfarm
