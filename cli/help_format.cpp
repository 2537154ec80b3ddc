#include "cli/help_format.h"

namespace lumenfarm {
namespace {

constexpr std::size_t help_column = 36;

}  // namespace

HelpFormat::HelpFormat() {
    label("SUBCOMMAND", "COMMAND");
    column_width(help_column);
}

std::string HelpFormat::make_option_opts(const CLI::Option* option) const {
    return option->get_type_size() == 0 || option->get_type_name().empty() ? "" : " " + option->get_type_name();
}

std::string HelpFormat::make_option_desc(const CLI::Option* option) const {
    std::string text = option->get_description();
    if (option->get_required() && !option->get_positional()) text += " (required)";
    if (option->get_type_size() != 0 && !option->get_default_str().empty())
        text += " (default: " + option->get_default_str() + ")";
    return text;
}

}  // namespace lumenfarm
