#include "master/snapshot_file.h"

#include "common/solution/solution_file.h"
#include "common/support/bytes.h"
#include "common/support/limits.h"

#include <xxhash.h>

#include <algorithm>
#include <utility>

namespace lumenfarm {

namespace {

constexpr std::uint64_t magic = 0x3450414e53464c4cu;  // "LLFSNAP4"
constexpr std::size_t checksum_bytes = 8;

Error damaged() { return bad_input("the snapshot is truncated or damaged"); }

Result<Partition> read_cut(ByteReader& in, std::size_t subspaces) {
    auto cut = Partition::check(in.block<Partition::Node>(2 * limits::subspaces_max));
    if (cut && cut->subspaces() != subspaces) return damaged();
    return cut;
}

Result<void> read_lessons(ByteReader& in, std::size_t subspaces, std::vector<CutLesson>& lessons) {
    const auto count = in.value<std::uint64_t>();
    if (count > limits::cut_lessons_max) return damaged();
    const auto is_possible = [](double times) { return times >= 1 / lesson_times_max && times <= lesson_times_max; };
    for (std::uint64_t i = 0; i < count; ++i) {
        auto cut = read_cut(in, subspaces);
        if (!cut) return cut.error();
        CutLesson lesson{std::move(*cut), in.block<double>(limits::subspaces_max)};
        if (lesson.times.size() != subspaces || !std::ranges::all_of(lesson.times, is_possible)) return damaged();
        lessons.push_back(std::move(lesson));
    }
    return {};
}

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
                                       const WorkTimes& work_times, const FlightQueues& flights,
                                       const std::vector<IntervalSet>& ended) {
    if (flights.subspaces() == 0) return solution;
    ByteWriter out;
    out.value(magic);
    out.block<std::byte>(solution);
    out.block<Partition::Node>(cut.nodes());
    out.block<SubspaceCost>(work_times.costs);
    out.value(static_cast<std::uint64_t>(work_times.lessons.size()));
    for (const CutLesson& lesson : work_times.lessons) {
        out.block<Partition::Node>(lesson.cut.nodes());
        out.block<double>(lesson.times);
    }
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
    JobSnapshot snapshot{{},
                         {},
                         {{}, std::vector<SubspaceCost>(subspaces)},
                         FlightQueues(subspaces),
                         std::vector<IntervalSet>(subspaces)};
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
    auto cut = read_cut(in, subspaces);
    if (!cut) return cut.error();
    snapshot.cut = std::move(*cut);
    snapshot.work_times.costs = in.block<SubspaceCost>(limits::subspaces_max);
    if (snapshot.work_times.costs.size() != subspaces) return damaged();
    if (const auto read = read_lessons(in, subspaces, snapshot.work_times.lessons); !read) return read.error();
    for (std::uint32_t subspace = 0; subspace < subspaces; ++subspace)
        if (const auto read = read_queue(in, subspace, snapshot); !read) return read.error();
    if (in.remaining() != 0) return damaged();
    return snapshot;
}

}  // namespace lumenfarm
