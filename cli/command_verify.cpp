#include "cli/commands.h"
#include "cli/options.h"
#include "cli/products/json_text.h"
#include "cli/verification.h"

#include <boost/json.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <thread>

/// `verify`: whether a result is what its particles give.
namespace lumenfarm {
namespace {

namespace json = boost::json;

/// By chance, so that nobody who made the result could know which.
std::vector<std::uint32_t> choose_batches(double fraction) {
    std::vector<std::uint32_t> batches(limits::batches);
    std::iota(batches.begin(), batches.end(), 0u);
    std::random_device entropy;
    std::shuffle(batches.begin(), batches.end(), std::mt19937(entropy()));
    batches.resize(
        static_cast<std::size_t>(std::clamp(std::ceil(fraction * limits::batches), 1.0, 1.0 * limits::batches)));
    std::sort(batches.begin(), batches.end());
    return batches;
}

class VerifyCommand : public Command {
public:
    explicit VerifyCommand(CLI::App& app)
        : Command(app, "verify", "Trace a random part of a result's particles again, and compare") {
        app_.add_option("DIR", path_, "The results' folder, or the solution.lfs in it")->type_name("")->required();
        real_option(app_, "--fraction", fraction_, "Of the particles, rounded up to 1/32; 1 compares everything");
        flag_option(app_, "--json", json_, "Print one JSON document");
    }

    Result<void> execute(Console& console) override {
        if (!(fraction_ > 0 && fraction_ <= 1)) return bad_input("--fraction must be above 0, and 1 at most");
        const auto run = load_run(path_);
        if (!run) return run.error();
        const auto tracer = TracerScene::make(run->scene);
        if (!tracer) return tracer.error();
        const unsigned threads = std::max(1u, std::thread::hardware_concurrency());
        const Verification found = verify(*run, **tracer, choose_batches(fraction_), threads, [&](double done) {
            console.progress("verifying: " + std::to_string(static_cast<int>(100 * done)) + " %");
        });
        console.end_progress("verified " + std::to_string(found.particles) + " particles");
        console.result(json_ ? document(found) : text(found));
        if (found.differences.empty()) return {};
        return failed("the result is not what its particles give: part of it was traced wrongly, or changed later");
    }

private:
    static std::string text(const Verification& found) {
        std::string lines = std::to_string(found.particles) + " particles (batches";
        for (const std::uint32_t batch : found.batches) lines += " " + std::to_string(batch);
        lines += ") leave " + std::to_string(found.hits) + " hits";
        if (found.differences.empty()) return lines + "; the result agrees";
        for (const std::string& difference : found.differences) lines += "\n" + difference;
        if (found.more_differences > 0) lines += "\nand " + std::to_string(found.more_differences) + " more";
        return lines;
    }
    static std::string document(const Verification& found) {
        return json_text({{"agrees", found.differences.empty()},
                          {"batches", json::value_from(found.batches)},
                          {"particles", found.particles},
                          {"hits", found.hits},
                          {"differences", json::value_from(found.differences)},
                          {"more_differences", found.more_differences}});
    }

    std::string path_;
    double fraction_ = 0.05;
    bool json_ = false;
};

}  // namespace

std::unique_ptr<Command> make_verify_command(CLI::App& app) { return std::make_unique<VerifyCommand>(app); }

}  // namespace lumenfarm
