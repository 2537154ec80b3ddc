#pragma once

#include <CLI/CLI.hpp>

#include <string>

namespace lumenfarm {

/// Help that is easy on the eye: no environment names, which follow a rule, and defaults in words.
class HelpFormat : public CLI::Formatter {
public:
    HelpFormat();
    std::string make_option_opts(const CLI::Option* option) const override;
    std::string make_option_desc(const CLI::Option* option) const override;
};

}  // namespace lumenfarm
