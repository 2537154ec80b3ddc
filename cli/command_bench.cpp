#include "cli/bench/tracer_bench.h"
#include "cli/bench_input.h"
#include "cli/commands.h"
#include "cli/number.h"
#include "cli/options.h"
#include "cli/products/json_text.h"

#include <boost/json.hpp>

#include <array>
#include <cstdio>

/// `bench`, and `bench tracer`: how fast this computer traces.
namespace lumenfarm {
namespace {

constexpr std::uint32_t rounds_max = 1'000;

boost::json::object document(const TracerBench& bench) {
    return {{"rays_per_s", bench.rays_per_s},
            {"embree_rays_per_s", bench.embree_rays_per_s},
            {"ratio", bench.ratio},
            {"particles_per_s", bench.particles_per_s},
            {"hits_per_particle", bench.hits_per_particle},
            {"rays", bench.rays},
            {"particles", bench.particles},
            {"triangles", bench.triangles},
            {"isa", bench.isa},
            {"rounds", bench.rounds}};
}

std::string table(const TracerBench& bench) {
    std::array<char, 512> buffer{};
    std::snprintf(buffer.data(), buffer.size(),
                  "tracing      %s rays/s, %s particles/s, %.2f hits a particle\n"
                  "bare Embree  %s rays/s over the same rays\n"
                  "ratio        %.3f\n"
                  "             one thread, %s, %llu triangles, medians of %u rounds of %s rays\n",
                  short_count(bench.rays_per_s).c_str(), short_count(bench.particles_per_s).c_str(),
                  bench.hits_per_particle, short_count(bench.embree_rays_per_s).c_str(), bench.ratio, bench.isa.c_str(),
                  static_cast<unsigned long long>(bench.triangles), bench.rounds,
                  short_count(static_cast<double>(bench.rays)).c_str());
    return buffer.data();
}

class TracerBenchCommand : public Command {
public:
    explicit TracerBenchCommand(CLI::App& app)
        : Command(app, "tracer", "Compare the tracer with bare Embree, on one thread") {
        declare_bench_input(app_, input_);
        count_option(app_, "--particles", particles_, "Particles in a round; 0 takes about 2M rays");
        count_option(app_, "--rounds", rounds_, "Rounds of each; the medians are shown");
        isa_option(app_, isa_);
        flag_option(app_, "--json", json_, "Print one JSON document");
    }

    Result<void> execute(Console& console) override {
        if (rounds_ < 1 || rounds_ > rounds_max)
            return bad_input("rounds is " + std::to_string(rounds_) + "; it must be from 1 to " +
                             std::to_string(rounds_max));
        const auto compiled = read_bench_scene(app_, input_, console);
        if (!compiled) return compiled.error();
        const auto bench = bench_tracer(compiled->scene, particles_, rounds_, isa_);
        if (!bench) return bench.error();
        console.result(json_ ? json_text(document(*bench)) : table(*bench));
        return {};
    }

private:
    BenchInput input_;
    std::uint64_t particles_ = 0;
    std::uint32_t rounds_ = 9;
    std::string isa_;
    bool json_ = false;
};

class BenchCommand : public Command {
public:
    BenchCommand(CLI::App& app, const FarmOptions& farm) : Command(app, "bench", "Measure how fast this computer is") {
        benches_.push_back(std::make_unique<TracerBenchCommand>(app_));
        benches_.push_back(make_farm_bench_command(app_));
        benches_.push_back(make_paced_bench_command(app_, farm));
        app_.require_subcommand(1);
    }
    Result<void> execute(Console& console) override {
        for (const auto& bench : benches_)
            if (bench->chosen()) return bench->execute(console);
        return {};
    }

private:
    std::vector<std::unique_ptr<Command>> benches_;
};

}  // namespace

std::unique_ptr<Command> make_bench_command(CLI::App& app, const FarmOptions& farm) {
    return std::make_unique<BenchCommand>(app, farm);
}

}  // namespace lumenfarm
