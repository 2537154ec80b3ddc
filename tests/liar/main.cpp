#include "worker/worker_client.h"

#include <CLI/CLI.hpp>

#include <array>
#include <bit>
#include <iostream>
#include <memory>
#include <random>
#include <utility>

/// lying-worker: lumenfarm-worker on a PC whose memory flips a bit now and then. What it says looks possible, and is
/// wrong.
namespace {

using namespace lumenfarm;

struct Lies {
    double fraction = 0;   ///< of the slices have, by chance, one bit of one hit flipped
    bool possible = true;  ///< the bit leaves it a hit that could be; false: any bit
};

class LyingTracer : public TracerScene {
public:
    LyingTracer(std::unique_ptr<TracerScene> honest, const Lies& lies) : honest_(std::move(honest)), lies_(lies) {}

    const Scene& scene() const override { return honest_->scene(); }
    const Emission& emission() const override { return honest_->emission(); }
    const RayQuery& query() const override { return honest_->query(); }
    std::string isa() const override { return honest_->isa(); }
    Meeting meet(Vec3d origin, Vec3d direction, std::uint32_t from_triangle) const override {
        return honest_->meet(origin, direction, from_triangle);
    }

    void follow(const JobSpec& spec, std::uint32_t light, std::span<const Flight> flights,
                TracedHits& hits) const override {
        honest_->follow(spec, light, flights, hits);
    }
    void trace(const JobSpec& spec, const ParticleRange& range, TracedHits& hits, RayLog* log) const override {
        thread_local std::mt19937_64 random{std::random_device{}()};
        const std::size_t before = hits.records.size();
        honest_->trace(spec, range, hits, log);
        const std::size_t made = hits.records.size() - before;
        if (made == 0 || !std::bernoulli_distribution(lies_.fraction)(random)) return;
        HitRecord& hit = hits.records[before + random() % made];
        if (lies_.possible) {
            hit.wavelength ^= 1u;
        } else {
            auto bytes = std::bit_cast<std::array<unsigned char, sizeof hit>>(hit);
            bytes[random() % bytes.size()] ^= static_cast<unsigned char>(1u << random() % 8);
            hit = std::bit_cast<HitRecord>(bytes);
        }
    }

private:
    std::unique_ptr<TracerScene> honest_;
    Lies lies_;
};

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("Lumenfarm's worker on a PC whose memory flips bits.", "lying-worker");
    WorkerOptions options;
    Lies lies;
    app.add_option("--master", options.master, "HOST:PORT of the master")->required();
    app.add_option("--threads", options.threads, "tracing threads");
    app.add_option("--cache", options.cache, "folder of fetched scenes")->required();
    app.add_option("--name", options.name, "how the master calls this worker")->required();
    app.add_option("--lies", lies.fraction, "fraction of the slices that are wrong")
        ->required()
        ->check(CLI::Range(0.0, 1.0));
    app.add_flag("!--impossible", lies.possible, "any bit is flipped (packing records only)");
    app.add_flag("--idle-priority,!--normal-priority", options.idle_priority, "as lumenfarm-worker's");
    CLI11_PARSE(app, argc, argv);
    const auto lying = [lies](const Scene& scene, const std::string& isa) -> Result<std::unique_ptr<TracerScene>> {
        auto honest = TracerScene::make(scene, isa);
        if (!honest) return honest.error();
        return std::unique_ptr<TracerScene>(std::make_unique<LyingTracer>(std::move(*honest), lies));
    };
    options.make_job = tracing_jobs(options.isa, lying);
    const auto worker = WorkerClient::start(options);
    const Result<void> ended = worker ? (*worker)->wait() : worker.error();
    if (!ended) std::cerr << ended.error().sentence << "\n";
    return ended ? 0 : exit_code(ended.error());
}
