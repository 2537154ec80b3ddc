#include "cli/options.h"

#include "cli/number.h"
#include "common/scene/text.h"

#include <array>
#include <cstdlib>
#include <filesystem>
#include <limits>

namespace lumenfarm {
namespace option_detail {

CLI::Option* declare(CLI::App& app, const std::string& names, const std::string& type, const std::string& shown_default,
                     const std::string& help, const std::function<std::string(const std::string&)>& parse) {
    const auto read = [parse, names](const CLI::results_t& texts) {
        const std::string refused = parse(texts.back());
        const auto dashes = names.rfind("--");
        if (!refused.empty())
            throw CLI::ValidationError(names.substr(dashes == std::string::npos ? 0 : dashes), refused);
        return true;
    };
    CLI::Option* option = app.add_option(names, read, help);
    option->type_name(type)->type_size(1)->expected(1);
    if (!shown_default.empty()) option->default_str(shown_default);
    if (!option->get_lnames().empty()) option->envname(environment_name(option->get_lnames().front()));
    return option;
}

std::string not_offered(const std::string& text, const std::vector<std::string>& words) {
    return "'" + clean_name(text) + "' is not one of " + CLI::detail::join(words, ", ");
}

}  // namespace option_detail

namespace {

/// A parser for declare() that keeps what `parse` makes of the text.
template <class Value, class Parse>
auto keeping(Value& value, Parse parse) {
    return [&value, parse](const std::string& text) -> std::string {
        auto parsed = parse(text);
        if (!parsed) return parsed.error().sentence;
        value = *parsed;
        return {};
    };
}

Result<std::uint32_t> parse_small_count(const std::string& text) {
    const auto count = parse_count(text);
    if (!count) return count.error();
    if (*count > std::numeric_limits<std::uint32_t>::max()) return bad_input("'" + text + "' is too large");
    return static_cast<std::uint32_t>(*count);
}

bool is_file(const std::string& path) {
    std::error_code error;
    return std::filesystem::is_regular_file(path, error);
}

std::string text_of_real(double value) {
    std::array<char, 32> buffer{};
    std::snprintf(buffer.data(), buffer.size(), "%g", value);
    return buffer.data();
}

}  // namespace

CLI::Option* text_option(CLI::App& app, const std::string& names, std::string& value, const std::string& help) {
    return option_detail::declare(app, names, "TEXT", value, help, [&value](const std::string& text) {
        value = text;
        return std::string();
    });
}

CLI::Option* flag_option(CLI::App& app, const std::string& names, bool& value, const std::string& help) {
    CLI::Option* option = app.add_flag(names, value, help);
    return option->envname(environment_name(option->get_lnames().front()));
}

CLI::Option* count_option(CLI::App& app, const std::string& names, std::uint64_t& value, const std::string& help) {
    return option_detail::declare(app, names, "N", std::to_string(value), help, keeping(value, parse_count));
}

CLI::Option* count_option(CLI::App& app, const std::string& names, std::uint32_t& value, const std::string& help) {
    return option_detail::declare(app, names, "N", std::to_string(value), help, keeping(value, parse_small_count));
}

CLI::Option* counts_option(CLI::App& app, const std::string& names, std::vector<std::uint64_t>& values,
                           const std::string& help) {
    std::string shown;
    for (const std::uint64_t value : values) shown += (shown.empty() ? "" : ",") + std::to_string(value);
    return option_detail::declare(app, names, "N,N...", shown, help, keeping(values, parse_counts));
}

CLI::Option* signed_option(CLI::App& app, const std::string& names, std::int32_t& value, const std::string& help) {
    return option_detail::declare(app, names, "N", std::to_string(value), help, keeping(value, parse_signed));
}

CLI::Option* real_option(CLI::App& app, const std::string& names, double& value, const std::string& help) {
    return option_detail::declare(app, names, "X", text_of_real(value), help, keeping(value, parse_real));
}

CLI::Option* vector_option(CLI::App& app, const std::string& names, std::optional<Vec3d>& value,
                           const std::string& help) {
    return option_detail::declare(app, names, "X,Y,Z", {}, help, keeping(value, parse_vector));
}

std::string environment_name(const std::string& long_name) {
    std::string name = "LUMENFARM_";
    for (const char c : long_name) name += c == '-' ? '_' : c >= 'a' && c <= 'z' ? static_cast<char>(c - 32) : c;
    return name;
}

std::string default_config_file() {
    if (const char* named = std::getenv("LUMENFARM_CONFIG"); named && *named) return named;
    if (const char* home = std::getenv("HOME"); home && *home) {
        const std::string own = std::string(home) + "/.config/lumenfarm/config.toml";
        if (is_file(own)) return own;
    }
    const std::string common = "/etc/lumenfarm/lumenfarm.toml";
    return is_file(common) ? common : std::string();
}

std::vector<CLI::ConfigItem> ConfigBehindEnvironment::from_config(std::istream& input) const {
    auto entries = CLI::ConfigTOML::from_config(input);
    std::erase_if(entries, [](const CLI::ConfigItem& item) {
        const char* set = std::getenv(environment_name(item.name).c_str());
        return set && *set;
    });
    return entries;
}

}  // namespace lumenfarm
