#include "cli/products/inspect.h"

#include "cli/products/format_line.h"
#include "common/solution/estimate.h"
#include "common/solution/solution.h"

#include <boost/json.hpp>

#include <algorithm>
#include <cmath>

namespace lumenfarm {
namespace {

namespace json = boost::json;

json::value number_or_null(double number) { return std::isfinite(number) ? json::value(number) : json::value(nullptr); }

json::object estimate_fields(const AreaEstimate& estimate) {
    return {{"area_m2", estimate.area_m2},
            {"hits", estimate.hits},
            {"irradiance_w_m2", estimate.irradiance_w_m2},
            {"illuminance_lx", estimate.illuminance_lx},
            {"standard_error_lx", number_or_null(estimate.standard_error_lx)},
            {"relative_error", number_or_null(estimate.relative_error)}};
}

json::object balance_fields(const LoadedRun& run) {
    const EnergyBalance& balance = run.solution.balance;
    const double watts = tick_value(run.emission, run.solution).watts;
    const auto in_watts = [&](std::int64_t ticks) { return static_cast<double>(ticks) * watts; };
    return {{"emitted_w", in_watts(balance.emitted)}, {"absorbed_w", in_watts(balance.absorbed)},
            {"escaped_w", in_watts(balance.escaped)}, {"cutoff_w", in_watts(balance.cut_off)},
            {"ticks_equal", balance.closed()},        {"emitted_ticks", balance.emitted},
            {"absorbed_ticks", balance.absorbed},     {"escaped_ticks", balance.escaped},
            {"cutoff_ticks", balance.cut_off},        {"bounce_limited", balance.bounce_limited}};
}

json::array light_fields(const LoadedRun& run) {
    json::array lights;
    for (std::size_t i = 0; i < run.scene.lights.size(); ++i)
        lights.push_back(json::object{{"name", run.scene.lights[i].name},
                                      {"flux_w", run.emission.lights[i].flux_w},
                                      {"flux_lm", run.emission.lights[i].flux_lm},
                                      {"particles", run.solution.committed[i].size()}});
    return lights;
}

json::array surface_fields(const LoadedRun& run) {
    const auto estimates = surface_estimates(run.scene, run.emission, run.solution);
    json::array surfaces;
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        json::object surface{{"name", run.scene.surfaces[i].name}, {"object", run.scene.surfaces[i].object}};
        for (auto& field : estimate_fields(estimates[i].total)) surface.insert(field);
        surface["front"] = estimate_fields(estimates[i].front);
        surface["back"] = estimate_fields(estimates[i].back);
        surfaces.push_back(std::move(surface));
    }
    return surfaces;
}

json::object time_fields(const SolutionTime& time) {
    return {{"total_s", time.total_s}, {"trace_s", time.trace_s}, {"workers", time.workers}};
}

json::object job_fields(const JobSpec& spec) {
    return {{"name", spec.name},
            {"particles", spec.particles},
            {"seed", spec.seed},
            {"absorption", spec.absorption == Absorption::analog ? "analog" : "attenuate"},
            {"cutoff_rule", spec.cutoff_rule == CutoffRule::roulette ? "roulette" : "plain"},
            {"cutoff", spec.cutoff},
            {"texel_m", spec.texel_m},
            {"keep_hits", spec.keep_hits}};
}

std::string percent(double relative_error) {
    return std::isfinite(relative_error) ? format_line("%.3g %%", 100 * relative_error) : "-";
}

}  // namespace

json::object inspect_document(const LoadedRun& run) {
    const Solution& solution = run.solution;
    return {{"digest", solution_digest(solution).hex()},
            {"scene", run.scene_name.hex()},
            {"particles", solution.balance.particles},
            {"particles_asked", solution.spec.particles},
            {"complete", solution.complete()},
            {"hits", solution.balance.hits},
            {"kept_hits", solution.kept.size()},
            {"texels", solution.texels.size()},
            {"balance", balance_fields(run)},
            {"lights", light_fields(run)},
            {"surfaces", surface_fields(run)},
            {"time", time_fields(solution.time)}};
}

json::object report_document(const LoadedRun& run, const std::vector<std::string>& pictures) {
    json::object report = inspect_document(run);
    report["job"] = job_fields(run.solution.spec);
    json::array names;
    for (const std::string& picture : pictures) names.emplace_back(picture);
    report["pictures"] = std::move(names);
    return report;
}

std::string inspect_table(const LoadedRun& run) {
    const Solution& solution = run.solution;
    const EnergyBalance& balance = solution.balance;
    const double watts = tick_value(run.emission, solution).watts;
    const auto in_watts = [&](std::int64_t ticks) { return static_cast<double>(ticks) * watts; };
    std::string text = "digest     " + solution_digest(solution).hex() + "\nscene      " + run.scene_name.hex() + "\n";
    text += format_line(
        "particles  %llu of %llu%s\nhits       %llu\n", static_cast<unsigned long long>(balance.particles),
        static_cast<unsigned long long>(solution.spec.particles),
        solution.complete() ? "" : " (the job was not finished)", static_cast<unsigned long long>(balance.hits));
    text += format_line("energy     emitted %.6g W = absorbed %.6g W + escaped %.6g W + cut off %.6g W%s\n",
                        in_watts(balance.emitted), in_watts(balance.absorbed), in_watts(balance.escaped),
                        in_watts(balance.cut_off), balance.closed() ? ", exact" : ", NOT EXACT");
    text += format_line("time       %.2f s in all, %.2f s of tracing, %u workers\n", solution.time.total_s,
                        solution.time.trace_s, solution.time.workers);
    text += "\nlight                             flux [W]     flux [lm]     particles\n";
    for (std::size_t i = 0; i < run.scene.lights.size(); ++i)
        text += format_line("%-30.30s %11.5g %13.5g %13llu\n", run.scene.lights[i].name.c_str(),
                            run.emission.lights[i].flux_w, run.emission.lights[i].flux_lm,
                            static_cast<unsigned long long>(solution.committed[i].size()));
    text += "\nsurface                          area [m2]   E [W/m2]     E [lx]     error          hits\n";
    const auto estimates = surface_estimates(run.scene, run.emission, solution);
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        const AreaEstimate& total = estimates[i].total;
        text += format_line("%-30.30s %11.5g %10.5g %10.5g %9s %13llu\n", run.scene.surfaces[i].name.c_str(),
                            total.area_m2, total.irradiance_w_m2, total.illuminance_lx,
                            percent(total.relative_error).c_str(), static_cast<unsigned long long>(total.hits));
    }
    return text;
}

}  // namespace lumenfarm
