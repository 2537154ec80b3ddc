#include "master/storage.h"

#include "common/solution/solution_file.h"

#include <utility>

namespace lumenfarm {

Result<std::vector<std::uint32_t>> Storage::admit(const Admit& admit) {
    auto missing = files_.missing(admit.submit.scene);
    if (!missing || !missing->empty()) return missing;
    const auto bytes = files_.read(admit.submit.scene.file);
    if (!bytes) return bytes.error();
    auto prepared = prepare_job(admit.submit.spec, *bytes);
    if (!prepared) return prepared.error();
    if (const auto stored = jobs_.put(admit.record); !stored) return stored.error();
    admitted_scene_ = admit.submit.scene.file;
    admitted_spec_ = admit.submit.spec;
    admitted_ = *prepared;
    return missing;
}

Result<std::shared_ptr<const PreparedJob>> Storage::prepare(const Prepare& prepare) {
    const auto admitted = std::exchange(admitted_, nullptr);
    if (admitted && admitted_scene_ == prepare.scene && admitted_spec_ == prepare.spec) return admitted;
    const auto bytes = files_.read(prepare.scene);
    if (!bytes) return bytes.error();
    return prepare_job(prepare.spec, *bytes);
}

Result<StoredSolution> Storage::store(const StoreSolution& effect) {
    const auto file = files_.put(encode_solution(*effect.solution));
    if (!file) return file.error();
    return StoredSolution{solution_digest(*effect.solution), *file};
}

wire::Message Storage::serve(const ServeManifest& serve) {
    auto manifest = files_.manifest(serve.file);
    if (!manifest) return wire::Refusal(wire::RefusalReason::no_such_file, manifest.error().sentence);
    return wire::Manifest(std::move(*manifest));
}

wire::Message Storage::serve(const ServeChunk& serve) const {
    auto bytes = files_.chunk(serve.file, serve.index);
    if (!bytes) return wire::Refusal(wire::RefusalReason::no_such_file, bytes.error().sentence);
    return wire::Chunk(serve.file, serve.index, std::move(*bytes));
}

}  // namespace lumenfarm
