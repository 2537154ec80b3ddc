#pragma once

#include "common/octree/subspaces.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

/// A cut in subspaces that comes nearer, from cut to cut, to sharing out the time that tracing takes
/// (docs/subspaces.md).
namespace lumenfarm {

/// What following particles took in a subspace.
struct SubspaceCost {
    std::uint64_t hits = 0;
    std::uint64_t nanoseconds = 0;
    bool operator==(const SubspaceCost&) const = default;
};

/// What was learned under a cut: work in a subspace counts so many times as much as was thought before.
struct CutLesson {
    Partition cut;
    std::vector<double> times;  ///< by subspace, each from 1 / lesson_times_max to lesson_times_max
    bool operator==(const CutLesson&) const = default;
};
inline constexpr double lesson_times_max = 8;

/// What is known of the time that work takes.
struct WorkTimes {
    std::vector<CutLesson> lessons;   ///< of cuts of before, the first one first
    std::vector<SubspaceCost> costs;  ///< of the cut in force, by subspace; empty, or of few hits: nothing is known
    bool operator==(const WorkTimes&) const = default;
};

/// Fewer measured hits than these, on average over the subspaces, teach nothing.
inline constexpr double costed_hits_min = 100;

/// How evenly a cut in subspaces shares the work so far out: the largest share over the mean.
struct Evenness {
    double now = 1;      ///< by the cut in force, or before it was cut anew
    double learned = 1;  ///< by the cut that it gives, as far as is known

    /// Uneven, and a new cut would be a good deal better.
    bool is_worth_a_cut(double above) const { return now > above && 1.1 * (learned - 1) < now - 1; }
};

struct LearnedCut {
    Evenness evenness;
    Partition cut;                    ///< that in force, where it is even enough
    std::optional<CutLesson> lesson;  ///< of the cut in force
};

/// Where a subspace took twice the time of its share of the work, its work counts as more from now on. Time is no sum
/// over space, since a ray that passes two subspaces is followed in both; so each cut only comes nearer. Early lessons
/// overshoot, later ones take smaller steps. `planned` (see corrected_work) and `hits`: the work. A cut that is not
/// more uneven than `above` stays. REQUIRES: lessons are of cuts in as many subspaces as `now`.
LearnedCut learn_cut(const Subspaces& now, std::vector<SpreadWork> planned, std::vector<SpreadWork> hits,
                     const WorkTimes& known, double above);

}  // namespace lumenfarm
