#include "cli/program.h"

#include "cli/commands.h"
#include "cli/help_format.h"
#include "cli/options.h"

#include <csignal>
#include <exception>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <vector>

namespace lumenfarm {
namespace {

constexpr const char* about =
    "Lumenfarm computes how light fills a scene, on this computer or on many.\n"
    "First steps:  lumenfarm run scenes/cornell.gltf -o out      (pictures and lux values into the folder out)\n"
    "              lumenfarm inspect out                         (what came out, surface by surface)";

constexpr const char* afterword =
    "'lumenfarm COMMAND --help' explains a command. Every option can also be set in the environment (--keep-hits as\n"
    "LUMENFARM_KEEP_HITS) and in the configuration file (keep-hits = \"1M\" under [run]).\n"
    "Exit status: 0 done, 1 failed, 2 bad input or usage, 3 interrupted with what was done kept.";

constexpr const char* afterword_of_commands =
    "Numbers may be written 25M, 25e6 or 25000000. 'lumenfarm --help' tells more.";

void declare_common(CLI::App& app, FarmOptions& farm) {
    app.require_subcommand(1);
    app.formatter(std::make_shared<HelpFormat>());
    app.footer(afterword_of_commands);  // commands take it over when they are declared
    app.set_version_flag("--version", std::string("lumenfarm ") + LUMENFARM_VERSION, "Print the version and exit");
    app.set_help_flag("-h,--help", "Print this help and exit");
    text_option(app, "--master", farm.master, "Where the master of the farm listens, for the commands that ask it")
        ->type_name("HOST:PORT");
    app.config_formatter(std::make_shared<ConfigBehindEnvironment>());
    app.set_config("--config", default_config_file(), "Configuration file (TOML)")->type_name("FILE");
    app.allow_config_extras(CLI::config_extras_mode::error);
}

std::vector<std::unique_ptr<Command>> declare_commands(CLI::App& app, const FarmOptions& farm) {
    std::vector<std::unique_ptr<Command>> commands;
    commands.push_back(make_run_command(app));
    commands.push_back(make_submit_command(app, farm));
    commands.push_back(make_status_command(app, farm));
    commands.push_back(make_workers_command(app, farm));
    commands.push_back(make_watch_command(app, farm));
    commands.push_back(make_why_command(app, farm));
    for (auto& command : make_control_commands(app, farm)) commands.push_back(std::move(command));
    commands.push_back(make_fetch_command(app, farm));
    commands.push_back(make_inspect_command(app));
    commands.push_back(make_verify_command(app));
    commands.push_back(make_measure_command(app));
    commands.push_back(make_render_command(app));
    commands.push_back(make_trace_command(app));
    commands.push_back(make_bench_command(app, farm));
    return commands;
}

/// CLI11 asks for a subcommand even where a word stands that is none.
std::string explain(const CLI::App& app, const CLI::ParseError& error) {
    const auto unknown = app.remaining();
    if (app.get_subcommands().empty() && !unknown.empty()) return "there is no command '" + unknown.front() + "'";
    return error.what();
}

/// The exit status where parsing ends the program: a wrong command line, or --help and --version, which are answered.
std::optional<int> parse(CLI::App& app, int argc, const char* const* argv, Console& console) {
    try {
        app.parse(argc, argv);
        return {};
    } catch (const CLI::Success& answered) {
        return app.exit(answered);
    } catch (const CLI::ParseError& error) {
        const Error wrong = bad_input(explain(app, error) + " ('lumenfarm --help' shows what can be said)");
        console.error(wrong);
        return exit_code(wrong);
    }
}

Result<void> execute(const std::vector<std::unique_ptr<Command>>& commands, Console& console) {
    for (const auto& command : commands) {
        if (!command->chosen()) continue;
        if (auto done = command->execute(console); !done) return done;
    }
    return console.finish();
}

}  // namespace

int run_program(int argc, const char* const* argv) {
    std::signal(SIGPIPE, SIG_IGN);  // a closed pipe is an error of writing, told as one
    Console console;
    FarmOptions farm;
    CLI::App app(about, "lumenfarm");
    declare_common(app, farm);
    const auto commands = declare_commands(app, farm);
    app.footer(afterword);
    try {
        if (const auto status = parse(app, argc, argv, console)) return *status;
        const auto done = execute(commands, console);
        if (done) return 0;
        console.error(done.error());
        return exit_code(done.error());
    } catch (const std::bad_alloc&) {
        console.error(failed("there is not enough memory"));
    } catch (const std::exception& error) {
        console.error(failed(std::string("unexpected: ") + error.what()));
    }
    return 1;
}

}  // namespace lumenfarm
