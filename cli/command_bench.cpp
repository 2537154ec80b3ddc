#include "cli/bench/cut_bench.h"
#include "cli/bench/tracer_bench.h"
#include "cli/bench_input.h"
#include "cli/commands.h"
#include "cli/number.h"
#include "cli/options.h"
#include "cli/products/json_text.h"
#include "common/support/limits.h"

#include <boost/json.hpp>

#include <algorithm>
#include <array>
#include <cstdio>
#include <iomanip>
#include <limits>
#include <sstream>

/// `bench`, and those of its kinds that need no farm: how fast this computer traces, how evenly cuts share the work
/// out.
namespace lumenfarm {
namespace {

constexpr std::uint32_t rounds_max = 1'000;
constexpr std::uint32_t cuts_max = limits::cut_lessons_max;

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

/// The figures of cuts in so many subspaces.
struct CutColumn {
    std::uint64_t subspaces = 0;
    std::vector<CutFigures> cuts;
};

boost::json::array document(const std::vector<CutColumn>& columns) {
    boost::json::array all;
    for (const auto& [subspaces, cuts] : columns) {
        boost::json::array rows;
        for (const CutFigures& each : cuts)
            rows.push_back(boost::json::object{{"cut", each.cut}, {"hits", each.of_hits}, {"time", each.of_time}});
        all.push_back(boost::json::object{{"subspaces", subspaces}, {"largest_over_mean", std::move(rows)}});
    }
    return all;
}

std::string table(const std::vector<CutColumn>& columns) {
    std::ostringstream text;
    text << "largest share of a subspace over the mean, of hits and of processor time\n"
         << std::left << std::setw(12) << "subspaces";
    for (const CutColumn& column : columns) text << std::right << std::setw(14) << column.subspaces;
    text << "\n" << std::fixed << std::setprecision(2);
    for (std::size_t row = 0; row < columns.front().cuts.size(); ++row) {
        text << std::left << std::setw(12) << columns.front().cuts[row].cut << std::right;
        for (const CutColumn& column : columns)
            text << std::setw(8) << column.cuts[row].of_hits << std::setw(6) << column.cuts[row].of_time;
        text << "\n";
    }
    return text.str();
}

class CutBenchCommand : public Command {
public:
    explicit CutBenchCommand(CLI::App& app)
        : Command(app, "cuts", "Show how evenly subspaces share the work out, before and after cuts learn") {
        declare_bench_input(app_, input_);
        counts_option(app_, "--subspaces", subspaces_, "Numbers of subspaces to compare");
        count_option(app_, "--cuts", cuts_, "Cuts that learn from those before");
        count_option(app_, "--particles", particles_, "Particles that each cut is measured by");
        flag_option(app_, "--json", json_, "Print one JSON document");
    }

    Result<void> execute(Console& console) override {
        if (cuts_ > cuts_max)
            return bad_input("cuts is " + std::to_string(cuts_) + "; at most " + std::to_string(cuts_max) +
                             " are learned here");
        const auto compiled = read_bench_scene(app_, input_, console);
        if (!compiled) return compiled.error();
        std::vector<CutColumn> columns;
        for (const std::uint64_t subspaces : subspaces_) {
            const auto count = static_cast<std::uint32_t>(
                std::min<std::uint64_t>(subspaces, std::numeric_limits<std::uint32_t>::max()));
            auto cuts = bench_cuts(compiled->scene, count, cuts_, particles_);
            if (!cuts) return cuts.error();
            columns.push_back({subspaces, std::move(*cuts)});
        }
        console.result(json_ ? json_text(document(columns)) : table(columns));
        return {};
    }

private:
    BenchInput input_;
    std::vector<std::uint64_t> subspaces_ = {8, 16, 64};
    std::uint32_t cuts_ = 17;
    std::uint64_t particles_ = 200'000;
    bool json_ = false;
};

class BenchCommand : public Command {
public:
    BenchCommand(CLI::App& app, const FarmOptions& farm) : Command(app, "bench", "Measure how fast this computer is") {
        benches_.push_back(std::make_unique<TracerBenchCommand>(app_));
        benches_.push_back(std::make_unique<CutBenchCommand>(app_));
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
