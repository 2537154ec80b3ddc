#include "common/transport/part_tracer.h"

#include "common/support/ensure.h"
#include "common/transport/bsdf.h"
#include "common/transport/follow.h"
#include "common/transport/wide_registers.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace lumenfarm {
namespace {

/// Particles are followed as long as they are in it.
class OneSubspace {
public:
    OneSubspace(const ScenePart& part, const Partition& partition, std::uint32_t subspace,
                std::vector<Departure>& departures)
        : part_(part), partition_(partition), subspace_(subspace), departures_(departures) {}

    bool enter(const Flights& flights, std::size_t lane, double from, EnergyBalance& balance) {
        const Stretch stretch = stretch_of(flights, lane, from);
        windows_.enters[lane] = stretch.enters;
        windows_.leaves[lane] = stretch.leaves;
        if (stretch.subspace == subspace_) return true;
        hand_over(flights, lane, stretch, balance);
        return false;
    }
    void find(const RayQuery& query, const Flights& flights, std::size_t active, MeetingLanes& meetings) const {
        query.nearest(flights.rays, windows_, active, meetings);
    }
    bool leave(const Flights& flights, std::size_t lane, const Step& step, EnergyBalance& balance) {
        if (step.meetings.triangle[lane] != none) return false;
        const double leaves = windows_.leaves[lane];
        hand_over(flights, lane,
                  leaves < std::numeric_limits<double>::infinity() ? stretch_of(flights, lane, leaves) : Stretch{},
                  balance);
        return true;
    }
    void move(std::size_t to, std::size_t from) {
        windows_.enters[to] = windows_.enters[from];
        windows_.leaves[to] = windows_.leaves[from];
    }

private:
    Stretch stretch_of(const Flights& flights, std::size_t lane, double from) const {
        return partition_.at(flights.rays.origin.at(lane), flights.rays.direction.at(lane), from);
    }
    void hand_over(const Flights& flights, std::size_t lane, const Stretch& next, EnergyBalance& balance) {
        Flight flight = flights.at(lane);
        if (flight.from_triangle != none) flight.from_triangle = part_.numbers[flight.from_triangle];
        depart(flight, next, departures_, balance);
    }

    const ScenePart& part_;
    const Partition& partition_;
    std::uint32_t subspace_;
    std::vector<Departure>& departures_;
    WindowLanes windows_;
};

class Tracer final : public PartTracer {
public:
    Tracer(ScenePart part, const Scene& palette, std::unique_ptr<RayQuery> query)
        : part_(std::move(part)),
          query_(std::move(query)),
          materials_(palette, part_.scene),
          surface_materials_(materials_by_surface(palette, part_.scene)) {}

    void trace(const JobSpec& spec, std::uint32_t light, std::span<const Flight> flights, const Partition& partition,
               std::uint32_t subspace, TracedHits& hits, std::vector<Departure>& departures) const override {
        const PathRules rules(materials_, query_->triangles(), surface_materials_, spec, light);
        Arrivals arrivals(flights, &part_.numbers);
        OneSubspace region(part_, partition, subspace, departures);
        const std::size_t before = hits.records.size();
        if (wide_registers_)
            follow_avx2(rules, arrivals, region, hits);
        else
            follow_baseline(rules, arrivals, region, hits);
        for (std::size_t i = before; i < hits.records.size(); ++i)
            hits.records[i].triangle = part_.numbers[hits.records[i].triangle];
    }

private:
    [[gnu::target("avx2,bmi,bmi2"), gnu::flatten]] void follow_avx2(const PathRules& rules, Arrivals& arrivals,
                                                                    OneSubspace& region, TracedHits& hits) const {
        follow(*query_, rules, arrivals, region, hits, nullptr);
    }
    [[gnu::flatten]] void follow_baseline(const PathRules& rules, Arrivals& arrivals, OneSubspace& region,
                                          TracedHits& hits) const {
        follow(*query_, rules, arrivals, region, hits, nullptr);
    }

    const bool wide_registers_ = has_wide_registers();
    ScenePart part_;
    std::unique_ptr<RayQuery> query_;
    MaterialTable materials_;
    std::vector<const Material*> surface_materials_;
};

}  // namespace

Result<std::unique_ptr<PartTracer>> PartTracer::make(ScenePart part, const Scene& palette, const SceneExtent& extent,
                                                     const std::string& isa) {
    ensure(part.numbers.size() == part.scene.triangles.size(), "a part numbers its triangles");
    auto query = RayQuery::make(part.scene, extent, isa);
    if (!query) return query.error();
    return std::unique_ptr<PartTracer>(std::make_unique<Tracer>(std::move(part), palette, std::move(query.value())));
}

}  // namespace lumenfarm
