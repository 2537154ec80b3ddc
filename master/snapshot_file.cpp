#include "master/snapshot_file.h"

#include "common/solution/solution_file.h"
#include "common/support/bytes.h"
#include "common/support/limits.h"

#include <xxhash.h>

#include <algorithm>
#include <utility>

namespace lumenfarm {

namespace {

constexpr std::uint64_t magic = 0x3350414e53464c4cu;  // "LLFSNAP3"
constexpr std::size_t checksum_bytes = 8;

Error damaged() { return bad_input("the snapshot is truncated or damaged"); }

/// One subspace: how many were filed, which of them have ended, and the others.
Result<void> read_queue(ByteReader& in, std::uint32_t subspace, JobSnapshot& snapshot) {
    const auto filed = in.value<std::uint64_t>();
    IntervalSet& ended = snapshot.ended[subspace];
    for (const auto& interval : in.block<IntervalSet::Interval>(in.remaining()))
        if (interval.end > filed || !ended.insert(interval.begin, interval.end)) return damaged();
    const FlightQueues::Flights flights = in.block<wire::FlightRecord>(in.remaining());
    if (!in.good() || ended.size() > filed || filed - ended.size() != flights.size() ||
        !std::all_of(flights.begin(), flights.end(), wire::possible_flight))
        return damaged();
    auto next = flights.begin();
    for (const auto& gap : ended.gaps(0, filed)) {
        const auto end = next + static_cast<std::ptrdiff_t>(gap.end - gap.begin);
        snapshot.flights.add({subspace, gap.begin, std::make_shared<const FlightQueues::Flights>(next, end)});
        next = end;
    }
    snapshot.flights.skip_to(subspace, filed);
    return {};
}

}  // namespace

std::vector<std::byte> encode_snapshot(std::vector<std::byte> solution, const Partition& cut,
                                       const std::vector<SubspaceCost>& costs, const FlightQueues& flights,
                                       const std::vector<IntervalSet>& ended) {
    if (flights.subspaces() == 0) return solution;
    ByteWriter out;
    out.value(magic);
    out.block<std::byte>(solution);
    out.block<Partition::Node>(cut.nodes());
    out.block<SubspaceCost>(costs);
    for (std::uint32_t subspace = 0; subspace < flights.subspaces(); ++subspace) {
        out.value(flights.filed(subspace));
        out.block<IntervalSet::Interval>(ended[subspace].intervals());
        FlightQueues::Flights left;
        for (const auto& gap : ended[subspace].gaps(0, flights.filed(subspace))) {
            const FlightQueues::Flights piece = flights.at(subspace, gap.begin, gap.end - gap.begin);
            left.insert(left.end(), piece.begin(), piece.end());
        }
        out.block<wire::FlightRecord>(left);
    }
    const std::uint64_t checksum = XXH3_64bits(out.bytes().data(), out.bytes().size());
    out.value(checksum);
    return out.take();
}

Result<JobSnapshot> decode_snapshot(std::span<const std::byte> bytes, const PreparedJob& prepared,
                                    const Digest& scene) {
    const std::size_t subspaces = prepared.sources() - prepared.particles.size();
    JobSnapshot snapshot{
        {}, {}, std::vector<SubspaceCost>(subspaces), FlightQueues(subspaces), std::vector<IntervalSet>(subspaces)};
    if (ByteReader(bytes).value<std::uint64_t>() != magic) {
        auto alone = decode_solution(bytes, prepared.scene, scene);
        if (!alone) return alone.error();
        snapshot.solution = std::move(*alone);
        return snapshot;
    }
    if (bytes.size() < checksum_bytes) return damaged();
    const std::span<const std::byte> body = bytes.first(bytes.size() - checksum_bytes);
    ByteReader checksum(bytes.subspan(body.size()));
    if (checksum.value<std::uint64_t>() != XXH3_64bits(body.data(), body.size())) return damaged();
    ByteReader in(body);
    (void)in.value<std::uint64_t>();
    auto solution = decode_solution(in.block<std::byte>(limits::solution_bytes_max), prepared.scene, scene);
    if (!solution) return solution.error();
    snapshot.solution = std::move(*solution);
    auto cut = Partition::check(in.block<Partition::Node>(2 * limits::subspaces_max));
    if (!cut) return cut.error();
    if (cut->subspaces() != subspaces) return damaged();
    snapshot.cut = std::move(*cut);
    snapshot.costs = in.block<SubspaceCost>(limits::subspaces_max);
    if (snapshot.costs.size() != subspaces) return damaged();
    for (std::uint32_t subspace = 0; subspace < subspaces; ++subspace)
        if (const auto read = read_queue(in, subspace, snapshot); !read) return read.error();
    if (in.remaining() != 0) return damaged();
    return snapshot;
}

}  // namespace lumenfarm
