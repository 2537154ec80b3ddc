#pragma once

#include "cli/command.h"

#include <memory>
#include <string>
#include <vector>

/// The subcommands, each in its own file.
namespace lumenfarm {

/// What all client commands share.
struct FarmOptions {
    std::string master = "127.0.0.1:7420";  ///< HOST:PORT
};

std::unique_ptr<Command> make_run_command(CLI::App& app);
std::unique_ptr<Command> make_inspect_command(CLI::App& app);
std::unique_ptr<Command> make_verify_command(CLI::App& app);
std::unique_ptr<Command> make_measure_command(CLI::App& app);
std::unique_ptr<Command> make_render_command(CLI::App& app);
std::unique_ptr<Command> make_trace_command(CLI::App& app);
std::unique_ptr<Command> make_farm_bench_command(CLI::App& bench);  ///< under `bench`

// `farm` outlives the command.
std::unique_ptr<Command> make_bench_command(CLI::App& app, const FarmOptions& farm);
std::unique_ptr<Command> make_paced_bench_command(CLI::App& bench, const FarmOptions& farm);  ///< under `bench`
std::unique_ptr<Command> make_submit_command(CLI::App& app, const FarmOptions& farm);
std::unique_ptr<Command> make_status_command(CLI::App& app, const FarmOptions& farm);
std::unique_ptr<Command> make_workers_command(CLI::App& app, const FarmOptions& farm);
std::unique_ptr<Command> make_watch_command(CLI::App& app, const FarmOptions& farm);
std::unique_ptr<Command> make_why_command(CLI::App& app, const FarmOptions& farm);
/// pause, resume, cancel, extend, remove
std::vector<std::unique_ptr<Command>> make_control_commands(CLI::App& app, const FarmOptions& farm);
std::unique_ptr<Command> make_fetch_command(CLI::App& app, const FarmOptions& farm);

}  // namespace lumenfarm
