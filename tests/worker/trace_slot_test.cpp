#include "worker/trace_slot.h"

#include "common/scene/scene_file.h"
#include "tests/scenes/planned_scene.h"
#include "tests/simulation/fake_tracer.h"
#include "tests/simulation/small_scene.h"
#include "worker/piece.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <ranges>
#include <utility>
#include <vector>

namespace lumenfarm {
namespace {

std::shared_ptr<const JobContext> job(Packing packing, std::uint64_t keep_hits = 0) {
    auto scene = std::make_shared<SceneContext>();
    scene->scene = testing::small_scene();
    scene->tracer = std::make_unique<testing::FakeTracer>(scene->scene);
    JobSpec spec;
    spec.packing = packing;
    spec.keep_hits = keep_hits;
    spec.hits_per_message = 700;
    return make_job_context({1, Digest{}, 0, spec, 0.2, 2}, scene, nullptr).value();
}

SetWork set(std::shared_ptr<const JobContext> job, std::uint64_t lease, std::uint64_t first, std::uint64_t count) {
    return {std::move(job), lease, 1, {0, first, count}, ~std::uint64_t{0}};
}

TraceSlot make_slot() {
    return TraceSlot({[] { return 0.0; }, [] { return 0.0; }});
}

SlotReport finish(TraceSlot& slot) {
    while (true)
        if (auto report = slot.advance(SlotAsk::nothing)) return std::move(*report);
}

TEST(TraceSlot, RecordsAreHandedOverAtTheEndOfTheSet) {
    TraceSlot slot = make_slot();
    slot.begin(set(job(Packing::records), 9, 100, 5'000));
    const SlotReport report = finish(slot);
    ASSERT_TRUE(report.result && report.set_finished && !report.open);
    ASSERT_EQ(report.result->claims.size(), 1u);
    EXPECT_EQ(report.result->claims[0], wire::Claim(9, 1, {0, 100, 5'000}));
    EXPECT_EQ(report.result->balance.particles, 5'000u);
    EXPECT_EQ(report.result->hits.at(0).records.size(), report.result->balance.hits);
}

TEST(TraceSlot, ClosingInTheMiddleClaimsWhatWasTracedAndTheRestFollows) {
    TraceSlot slot = make_slot();
    slot.begin(set(job(Packing::records), 9, 0, 5'000));
    EXPECT_FALSE(slot.advance(SlotAsk::nothing));
    const auto part = slot.advance(SlotAsk::close);
    ASSERT_TRUE(part && part->result && part->set_left);
    EXPECT_EQ(part->result->claims[0].range, (ParticleRange{0, 0, limits::slice_particles}));
    const SlotReport rest = finish(slot);
    EXPECT_EQ(rest.result->claims[0].range,
              (ParticleRange{0, limits::slice_particles, 5'000 - limits::slice_particles}));
}

TEST(TraceSlot, MapsGatherSetsAndEqualTheSumOfTheirRecords) {
    const auto maps = job(Packing::maps, 100);
    TraceSlot slot = make_slot();
    slot.begin(set(maps, 1, 0, 3'000));
    EXPECT_TRUE(finish(slot).open);
    slot.begin(set(maps, 2, 7'000, 2'000));
    finish(slot);
    const Parcel parcel = *slot.advance(SlotAsk::close)->result;
    EXPECT_EQ(parcel.claims.size(), 2u);
    LightMap expected(*maps->layout);
    TracedHits hits;
    maps->scene->tracer->trace(maps->spec, {0, 0, 3'000}, hits);
    maps->scene->tracer->trace(maps->spec, {0, 7'000, 2'000}, hits);
    expected.add(maps->scene->tracer->emission(), 0, hits.records, {});
    std::uint64_t sum = 0;
    for (const wire::TexelDelta& delta : parcel.texels) {
        EXPECT_EQ(delta.radiant, expected.texels()[delta.texel].radiant);
        EXPECT_EQ(delta.y_squared, expected.texels()[delta.texel].y_squared);
        sum += delta.hits;
    }
    EXPECT_EQ(sum, hits.records.size());
    EXPECT_EQ(parcel.kept.size(), hits.records.size()) << "all are candidates under the highest threshold";
    EXPECT_FALSE(slot.advance(SlotAsk::close)->result) << "nothing is handed over twice";
}

TEST(TraceSlot, AbandonedWorkLeavesNothingBehind) {
    const auto maps = job(Packing::maps);
    TraceSlot slot = make_slot();
    slot.begin(set(maps, 1, 0, 5'000));
    slot.advance(SlotAsk::nothing);
    const auto report = slot.advance(SlotAsk::abandon);
    EXPECT_TRUE(report && !report->set_left && !report->open && !report->result);
    slot.begin(set(maps, 2, 0, 1'000));
    finish(slot);
    const Parcel parcel = *slot.advance(SlotAsk::close)->result;
    std::uint64_t sum = 0;
    for (const wire::TexelDelta& delta : parcel.texels) sum += delta.hits;
    EXPECT_EQ(sum, parcel.balance.hits);
    EXPECT_EQ(parcel.claims.size(), 1u);
}

TEST(TraceSlot, HitsAboveTheThresholdAreNotCandidates) {
    const auto maps = job(Packing::maps, 100);
    TraceSlot slot = make_slot();
    SetWork work = set(maps, 1, 0, 3'000);
    work.keep_threshold = ~std::uint64_t{0} / 4;
    slot.begin(std::move(work));
    finish(slot);
    const Parcel parcel = *slot.advance(SlotAsk::close)->result;
    EXPECT_LT(parcel.kept.size(), parcel.balance.hits / 2);
    for (const KeptHit& hit : parcel.kept) EXPECT_LE(keep_priority(hit), ~std::uint64_t{0} / 4);
}

TEST(TraceSlot, LongSetsGiveSeveralResultsOfBoundedSize) {
    TraceSlot slot = make_slot();
    slot.begin(set(job(Packing::records), 1, 0, 1'000'000));
    std::uint64_t results = 0, particles = 0;
    for (bool finished = false; !finished; ++results) {
        const SlotReport report = finish(slot);
        finished = report.set_finished;
        particles += report.result->balance.particles;
        EXPECT_LE(report.result->hits.at(0).records.size() * sizeof(HitRecord),
                  limits::result_close_bytes + limits::slice_particles * 3 * sizeof(HitRecord));
    }
    EXPECT_GT(results, 1u);
    EXPECT_EQ(particles, 1'000'000u);
}

/// Two slots have half of the subspaces each.
class SlotsInSubspaces : public ::testing::TestWithParam<Packing> {
protected:
    SlotsInSubspaces() {
        JobSpec spec;
        spec.strategy = Strategy::subspaces;
        spec.packing = GetParam();
        const auto plan = make_plan_context(encode_plan(planned_.plan)).value();
        job_ = make_job_context({1, Digest{}, 0, spec, 0.2, 2}, nullptr, plan).value();
        for (std::uint32_t half = 0; half < 2; ++half) {
            std::vector<std::shared_ptr<const PartTracer>> parts(planned_.parts.size());
            for (std::uint32_t s = half; s < parts.size(); s += 2)
                parts[s] = make_piece(s, planned_.part_bytes[s], plan, {}).value().part;
            halves_.push_back(std::make_shared<const Territory>(plan->plan.partition, std::move(parts)));
        }
    }

    /// Traces a set to its end and keeps what comes out.
    void trace(const ParticleRange& range, std::vector<wire::FlightRecord> flights,
               std::shared_ptr<const Territory> half) {
        TraceSlot slot = make_slot();
        std::int64_t entered = 0, departed = 0;
        for (const wire::FlightRecord& flight : flights) entered += flight.energy;
        slot.begin({job_, 1, 1, range, ~std::uint64_t{0}, std::move(flights), std::move(half)});
        auto report = finish(slot);
        if (!report.result) report = *slot.advance(SlotAsk::close);
        ParcelReader reader(*report.result, 1);
        std::uint32_t parts = 0;
        while (const auto message = reader.next()) {
            if (const auto* leaving = std::get_if<wire::ResultFlights>(&*message)) {
                auto& waiting = waiting_[leaving->subspace];
                waiting.insert(waiting.end(), leaving->flights.begin(), leaving->flights.end());
                for (const wire::FlightRecord& flight : leaving->flights) departed += flight.energy;
            } else if (const auto* hits = std::get_if<wire::ResultHits>(&*message)) {
                hits_ += hits->records.size();
            } else if (const auto* map = std::get_if<wire::ResultMap>(&*message)) {
                for (const wire::TexelDelta& texel : map->texels) hits_ += texel.hits;
            } else if (const auto* work = std::get_if<wire::ResultWork>(&*message)) {
                EXPECT_TRUE(work->valid());
                for (const SubspaceWork& each : work->work) measured_[each.subspace] += each.hits;
            } else {
                EXPECT_EQ(std::get<wire::ResultDone>(*message).parts, parts);
            }
            ++parts;
        }
        const EnergyBalance& balance = report.result->balance;
        EXPECT_EQ(balance.emitted + entered, balance.absorbed + balance.escaped + balance.cut_off + departed);
        balance_ += balance;
    }

    testing::PlannedScene planned_{8};
    std::shared_ptr<const JobContext> job_;
    std::vector<std::shared_ptr<const Territory>> halves_;
    std::map<std::uint32_t, std::vector<wire::FlightRecord>> waiting_;  ///< by subspace
    std::map<std::uint32_t, std::uint64_t> measured_;                   ///< hits, by subspace
    EnergyBalance balance_;
    std::uint64_t hits_ = 0;
};

TEST_P(SlotsInSubspaces, OneWithTheWholeSceneHasNothingToSendOn) {
    const auto scene_bytes = encode_scene(planned_.scene);
    const auto all = std::make_shared<const Territory>(make_piece(none, scene_bytes, job_->plan, {}).value().whole);
    TracedHits alone;
    TracerScene::make(planned_.scene).value()->trace(job_->spec, {1, 0, 5'000}, alone);
    trace({1, 0, 5'000}, {}, all);
    EXPECT_TRUE(waiting_.empty());
    EXPECT_TRUE(measured_.empty()) << "who has all at hand does not know in which subspace a particle is";
    EXPECT_EQ(balance_, alone.balance);
    EXPECT_EQ(hits_, alone.records.size());
}

TEST_P(SlotsInSubspaces, AnotherSceneIsNotThatOfThePlan) {
    const auto other = make_piece(none, encode_scene(testing::hills_room(3)), job_->plan, {});
    ASSERT_FALSE(other);
    EXPECT_EQ(other.error().code, ErrorCode::bad_input);
}

TEST_P(SlotsInSubspaces, TogetherTraceWhatOneTracesAlone) {
    TracedHits alone;
    const auto tracer = std::move(TracerScene::make(planned_.scene).value());
    for (std::uint32_t light = 0; light < 2; ++light) {
        tracer->trace(job_->spec, {light, 0, 40'000}, alone);
        trace({light, 0, 40'000}, {}, halves_[light]);
    }
    std::uint64_t sets = 0;
    for (; !waiting_.empty(); ++sets) {
        auto [subspace, flights] = *waiting_.begin();
        waiting_.erase(waiting_.begin());
        const std::uint64_t count = flights.size();
        trace({2 + subspace, 100, count}, std::move(flights), halves_[subspace % 2]);
    }
    EXPECT_GT(sets, 8u);
    std::uint64_t measured = 0;
    for (const auto& [subspace, hits] : measured_) measured += hits;
    EXPECT_EQ(measured_.size(), 8u);
    EXPECT_GT(measured, 1'000u);
    EXPECT_LT(measured, alone.records.size()) << "some slices stand for all";
    EXPECT_EQ(balance_, alone.balance);
    EXPECT_EQ(hits_, alone.records.size());
}

TEST_P(SlotsInSubspaces, ASliceThatHasLeftManyHitsSendsTheRestOn) {
    for (std::uint32_t light = 0; light < 2; ++light) trace({light, 0, 40'000}, {}, halves_[0]);
    // for one slice, light by light
    std::vector<wire::FlightRecord> flights;
    const std::uint32_t subspace = waiting_.begin()->first;
    constexpr std::ptrdiff_t of_each = 300;
    for (std::uint32_t light = 0; light < 2; ++light)
        std::ranges::copy(waiting_.at(subspace) | std::views::filter([light](const auto& flight) {
                              return flight.light == light;
                          }) | std::views::take(of_each),
                          std::back_inserter(flights));
    ASSERT_EQ(std::ssize(flights), 2 * of_each);
    TraceSlot slot({[] { return 0.0; }, [] { return 0.0; }}, 1);
    slot.begin({job_, 1, 1, {2 + subspace, 0, flights.size()}, ~std::uint64_t{0}, flights, halves_[subspace % 2]});
    auto report = finish(slot);
    if (!report.result) report = *slot.advance(SlotAsk::close);
    EXPECT_GT(report.result->balance.hits, 0u) << "of the first light";
    std::ptrdiff_t second_left = 0;
    for (const auto& [to, leaving] : report.result->flights)
        second_left += std::ranges::count(leaving, 1u, &wire::FlightRecord::light);
    EXPECT_EQ(second_left, of_each);
}

INSTANTIATE_TEST_SUITE_P(Packing, SlotsInSubspaces, ::testing::Values(Packing::records, Packing::maps),
                         [](const auto& tested) { return tested.param == Packing::maps ? "Maps" : "Records"; });

TEST(ParcelReader, PartsHaveTheAskedSizeInOrderAndThenTheEnd) {
    TraceSlot slot = make_slot();
    slot.begin(set(job(Packing::records), 1, 0, 5'000));
    const Parcel parcel = *finish(slot).result;
    ParcelReader reader(parcel, 3);
    for (int round = 0; round < 2; ++round, reader.rewind()) {
        std::vector<HitRecord> records;
        std::uint32_t parts = 0;
        while (const auto message = reader.next()) {
            if (const auto* done = std::get_if<wire::ResultDone>(&*message)) {
                EXPECT_EQ(done->parts, parts);
                EXPECT_TRUE(done->valid());
                continue;
            }
            const auto& part = std::get<wire::ResultHits>(*message);
            EXPECT_EQ(part.part, wire::PartId(1, 3, parts++));
            EXPECT_LE(part.records.size(), 700u);
            records.insert(records.end(), part.records.begin(), part.records.end());
        }
        EXPECT_EQ(records, parcel.hits.at(0).records);
        EXPECT_TRUE(reader.finished());
    }
}

TEST(Parcel, AddsUpWorkToWhatAMessageMaySay) {
    constexpr auto hits_max = static_cast<std::uint32_t>(limits::hits_per_map_max);
    Parcel parcel;
    for (int i = 0; i < 3; ++i) {
        parcel.add_work({7, 5, 1'000});
        parcel.add_work({8, hits_max, wire::work_nanoseconds_max});
    }
    ParcelReader reader(parcel, 1);
    const auto work = std::get<wire::ResultWork>(*reader.next());
    EXPECT_EQ(work.work, (std::vector<SubspaceWork>{{7, 15, 3'000}, {8, hits_max, wire::work_nanoseconds_max}}));
    EXPECT_TRUE(work.valid());
}

TEST(ParcelReader, FlightsGoInPartsOfTheAskedSizeToo) {
    Parcel parcel;
    parcel.job = 1;
    parcel.hits_per_message = 700;
    parcel.flights[4].resize(1'500);
    parcel.flights[9].resize(10);
    std::vector<std::pair<std::uint32_t, std::size_t>> parts;
    ParcelReader reader(parcel, 3);
    while (const auto message = reader.next())
        if (const auto* part = std::get_if<wire::ResultFlights>(&*message))
            parts.emplace_back(part->subspace, part->flights.size());
    EXPECT_EQ(parts, (std::vector<std::pair<std::uint32_t, std::size_t>>{{4, 700}, {4, 700}, {4, 100}, {9, 10}}));
}

TEST(ParcelReader, PartsAreLargerThanAskedWhereAResultWouldHaveTooMany) {
    Parcel parcel;
    parcel.hits_per_message = 1;
    parcel.flights[4].resize(3 * limits::parts_per_result_max);
    parcel.hits.push_back({0, std::vector<HitRecord>(3 * limits::parts_per_result_max), {}});
    std::uint32_t parts = 0;
    ParcelReader reader(parcel, 3);
    while (reader.next()) ++parts;
    EXPECT_LE(parts, limits::parts_per_result_max);
    EXPECT_GT(parts, limits::parts_per_result_max / 4);
}

}  // namespace
}  // namespace lumenfarm
