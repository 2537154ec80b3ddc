#pragma once

#include "common/math/vec.h"

#include <CLI/CLI.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

/// One declaration an option: `--keep-hits` on the command line, LUMENFARM_KEEP_HITS in the environment, `keep-hits` in
/// the configuration file. The command line goes before the environment, the environment before the file.
namespace lumenfarm {

/// Named by `names` ("-o,--output"); from the environment by its long name.
CLI::Option* text_option(CLI::App& app, const std::string& names, std::string& value, const std::string& help);
CLI::Option* flag_option(CLI::App& app, const std::string& names, bool& value, const std::string& help);
CLI::Option* count_option(CLI::App& app, const std::string& names, std::uint64_t& value, const std::string& help);
CLI::Option* count_option(CLI::App& app, const std::string& names, std::uint32_t& value, const std::string& help);
/// "1,2,4"
CLI::Option* counts_option(CLI::App& app, const std::string& names, std::vector<std::uint64_t>& values,
                           const std::string& help);
CLI::Option* signed_option(CLI::App& app, const std::string& names, std::int32_t& value, const std::string& help);
CLI::Option* real_option(CLI::App& app, const std::string& names, double& value, const std::string& help);
CLI::Option* vector_option(CLI::App& app, const std::string& names, std::optional<Vec3d>& value,
                           const std::string& help);

/// What choice_option offers: words and what they stand for.
template <class Value>
using Choices = std::vector<std::pair<std::string, Value>>;

template <class Value>
CLI::Option* choice_option(CLI::App& app, const std::string& names, Value& value, const Choices<Value>& choices,
                           const std::string& help);

/// The environment variable of an option: LUMENFARM_ and the long name in capitals.
std::string environment_name(const std::string& long_name);

/// The configuration file in force: $LUMENFARM_CONFIG, ~/.config/lumenfarm/config.toml, or
/// /etc/lumenfarm/lumenfarm.toml, the first that exists; else empty.
std::string default_config_file();

/// TOML without the entries that the environment also sets.
class ConfigBehindEnvironment : public CLI::ConfigTOML {
public:
    std::vector<CLI::ConfigItem> from_config(std::istream& input) const override;
};

// Implementation.

namespace option_detail {

/// Reads the text by `parse`, which returns the sentence of an error, and gives the option its names.
CLI::Option* declare(CLI::App& app, const std::string& names, const std::string& type, const std::string& shown_default,
                     const std::string& help, const std::function<std::string(const std::string&)>& parse);
std::string not_offered(const std::string& text, const std::vector<std::string>& words);

}  // namespace option_detail

template <class Value>
CLI::Option* choice_option(CLI::App& app, const std::string& names, Value& value, const Choices<Value>& choices,
                           const std::string& help) {
    std::vector<std::string> words;
    std::string shown;
    for (const auto& [word, meaning] : choices) {
        words.push_back(word);
        if (meaning == value) shown = word;
    }
    return option_detail::declare(app, names, CLI::detail::join(words, "|"), shown, help,
                                  [&value, choices, words](const std::string& text) -> std::string {
                                      for (const auto& [word, meaning] : choices)
                                          if (word == text) {
                                              value = meaning;
                                              return {};
                                          }
                                      return option_detail::not_offered(text, words);
                                  });
}

}  // namespace lumenfarm
