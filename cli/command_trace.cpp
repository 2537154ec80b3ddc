#include "cli/commands.h"
#include "cli/job_options.h"
#include "cli/light_choice.h"
#include "cli/number.h"
#include "cli/options.h"
#include "cli/path_text.h"
#include "cli/products/json_text.h"
#include "cli/scene_input.h"
#include "common/scene/scene_file.h"
#include "common/support/limits.h"

#include <boost/json.hpp>

#include <memory>
#include <string>

/// `trace`: the paths of some particles, hit by hit.
namespace lumenfarm {
namespace {

namespace json = boost::json;

class TraceCommand : public Command {
public:
    explicit TraceCommand(CLI::App& app)
        : Command(app, "trace", "Show the paths of some particles, hit by hit, as a job traces them") {
        scene_.ceiling_light = "--ceiling-light";
        declare_scene_options(app_, scene_);
        // not from the environment: there the two names mean other things
        app_.add_option("--light", light_, "The light's name, or its number from 0")->type_name("LIGHT")->required();
        app_.add_option("--particles", range_, "Their numbers within the light: A..B, both included, or A alone")
            ->type_name("A..B")
            ->required();
        flag_option(app_, "--json", json_, "Print one JSON document");
        choice_option<std::string>(app_, "--isa", isa_,
                                   {{"auto", ""}, {"sse4.2", "sse4.2"}, {"avx2", "avx2"}, {"avx512", "avx512"}},
                                   "Instruction set of the ray queries; what comes out is the same");
        declare_path_options(app_, spec_);
    }

    Result<void> execute(Console& console) override {
        const auto range = checked_range();
        if (!range) return range.error();
        if (auto valid = validate(spec_); !valid) return valid;
        const auto compiled = read_scene(scene_, console);
        if (!compiled) return compiled.error();
        const auto light = choose_light(compiled->scene, light_);
        if (!light) return light.error();
        const auto tracer = TracerScene::make(compiled->scene, isa_);
        if (!tracer) return tracer.error();
        const std::string digest = scene_digest(compiled->bytes).hex();
        return json_ ? print_document(**tracer, *light, *range, digest, console)
                     : print_text(**tracer, *light, *range, digest, console);
    }

private:
    Result<CountRange> checked_range() const {
        auto range = parse_range(range_);
        if (!range) return bad_input("--particles: " + range.error().sentence);
        if (range->last >= limits::particles_max)
            return bad_input("--particles: '" + range_ + "' reaches beyond the last possible particle, " +
                             std::to_string(limits::particles_max - 1));
        return range;
    }

    /// Line by line, so that a particle that ends the program is the one after the last that was printed.
    Result<void> print_text(const TracerScene& tracer, std::uint32_t light, const CountRange& range,
                            const std::string& digest, Console& console) const {
        console.result("scene " + digest + ", light " + std::to_string(light) + " '" +
                       tracer.scene().lights[light].name + "'");
        EnergyBalance balance;
        for (std::uint64_t particle = range.first; particle <= range.last; ++particle) {
            const TracedPath path = trace_path(tracer, spec_, light, particle);
            console.result(path_text(tracer.scene(), path));
            if (auto printed = console.finish(); !printed) return printed;
            balance += path.balance;
        }
        console.result(balance_text(balance));
        return {};
    }

    /// Path by path: a document of many does not fit into memory.
    Result<void> print_document(const TracerScene& tracer, std::uint32_t light, const CountRange& range,
                                const std::string& digest, Console& console) const {
        const json::object light_document{{"number", light}, {"name", tracer.scene().lights[light].name}};
        console.result("{\n\"scene\": " + json::serialize(json::value(digest)) +
                       ",\n\"light\": " + json::serialize(light_document) +
                       ",\n\"seed\": " + std::to_string(spec_.seed) + ",\n\"paths\": [");
        EnergyBalance balance;
        for (std::uint64_t particle = range.first; particle <= range.last; ++particle) {
            const TracedPath path = trace_path(tracer, spec_, light, particle);
            std::string text = json_text(path_document(tracer.scene(), path));
            if (particle < range.last) text.insert(text.size() - 1, ",");
            console.result(text);
            if (auto printed = console.finish(); !printed) return printed;
            balance += path.balance;
        }
        console.result("],\n\"balance\": " + json_text(balance_document(balance)) + "}");
        return {};
    }

    SceneOptions scene_;
    JobSpec spec_;
    std::string light_;
    std::string range_;
    std::string isa_;
    bool json_ = false;
};

}  // namespace

std::unique_ptr<Command> make_trace_command(CLI::App& app) { return std::make_unique<TraceCommand>(app); }

}  // namespace lumenfarm
