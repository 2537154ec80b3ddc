#pragma once

#include "cli/console.h"
#include "common/support/result.h"

#include <CLI/CLI.hpp>

#include <memory>
#include <string>
#include <vector>

namespace lumenfarm {

/// A subcommand: its constructor declares the options, execute() runs with what was parsed.
class Command {
public:
    virtual ~Command() = default;
    Command(const Command&) = delete;
    Command& operator=(const Command&) = delete;

    bool chosen() const { return app_.parsed(); }
    /// The error's code decides the exit status.
    virtual Result<void> execute(Console& console) = 0;

protected:
    /// Options that `parent` declares may stand behind the subcommand, too.
    Command(CLI::App& parent, const std::string& name, const std::string& help)
        : app_(*parent.add_subcommand(name, help)->fallthrough()->group("Commands")) {}

    CLI::App& app_;
};

}  // namespace lumenfarm
