#include "common/solution/cut_learning.h"

#include "common/solution/hit_work.h"
#include "common/support/limits.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace lumenfarm {
namespace {

/// The power of what a lesson found, after so many others. Measured: long first steps save cuts, and short late ones
/// leave alone what is even.
double step(std::size_t lessons) { return std::max(0.25, 2 * std::pow(0.9, static_cast<double>(lessons))); }

void weigh_by(const CutLesson& lesson, std::vector<SpreadWork>& work) {
    for (SpreadWork& each : work) each.work *= lesson.times[lesson.cut.of((each.box.low + each.box.high) * 0.5)];
}

/// By subspace: its time over its work, both as shares of all. Nothing where too little was measured.
std::vector<double> slowness(const std::vector<double>& work, const std::vector<SubspaceCost>& costs) {
    double hits = 0, nanoseconds = 0;
    for (const SubspaceCost& each : costs) {
        hits += static_cast<double>(each.hits);
        nanoseconds += static_cast<double>(each.nanoseconds);
    }
    const double all_work = std::accumulate(work.begin(), work.end(), 0.0);
    if (hits < costed_hits_min * static_cast<double>(work.size()) || nanoseconds <= 0 || all_work <= 0) return {};
    std::vector<double> slowness;
    for (std::size_t subspace = 0; subspace < work.size(); ++subspace) {
        // as if some average hits had been there as well: few hits say little of what others take
        const double time = hits * static_cast<double>(costs[subspace].nanoseconds) / nanoseconds;
        slowness.push_back((time + costed_hits_min) / (hits * work[subspace] / all_work + costed_hits_min));
    }
    return slowness;
}

}  // namespace

LearnedCut learn_cut(const Subspaces& now, std::vector<SpreadWork> planned, std::vector<SpreadWork> hits,
                     const WorkTimes& known, double above) {
    for (const CutLesson& lesson : known.lessons) weigh_by(lesson, hits);
    std::vector<double> shares = now.shares(hits);
    const bool may_learn = known.lessons.size() < limits::cut_lessons_max;
    const std::vector<double> times = may_learn ? slowness(shares, known.costs) : std::vector<double>();
    for (std::size_t subspace = 0; subspace < times.size(); ++subspace) shares[subspace] *= times[subspace];

    LearnedCut learned;
    learned.evenness.now = learned.evenness.learned = imbalance(shares);
    learned.cut = now.partition();
    if (learned.evenness.now <= above) return learned;
    if (!times.empty()) {
        learned.lesson = CutLesson{now.partition(), {}};
        for (const double each : times)
            learned.lesson->times.push_back(
                std::clamp(std::pow(each, step(known.lessons.size())), 1 / lesson_times_max, lesson_times_max));
        weigh_by(*learned.lesson, hits);
    }
    const Subspaces cut = Subspaces::cut(now.root(), corrected_work(std::move(planned), hits),
                                         static_cast<std::uint32_t>(now.all().size()));
    learned.evenness.learned = imbalance(cut.shares(hits));
    learned.cut = cut.partition();
    return learned;
}

}  // namespace lumenfarm
