#include "cli/options.h"

#include "cli/job_options.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace lumenfarm {
namespace {

/// Sets a variable for one test.
class Variable {
public:
    Variable(std::string name, const std::string& value) : name_(std::move(name)) {
        ::setenv(name_.c_str(), value.c_str(), 1);
    }
    ~Variable() { ::unsetenv(name_.c_str()); }
    Variable(const Variable&) = delete;
    Variable& operator=(const Variable&) = delete;

private:
    std::string name_;
};

/// A program with the job options, as `run` has them. Gives the sentence of what is wrong.
std::string parse(JobSpec& spec, std::vector<std::string> arguments, const std::string& config = {}) {
    CLI::App app;
    app.config_formatter(std::make_shared<ConfigBehindEnvironment>());
    app.set_config("--config", config);
    app.allow_config_extras(CLI::config_extras_mode::error);
    declare_job_options(*app.add_subcommand("run"), spec);
    arguments.insert(arguments.begin(), "run");
    std::reverse(arguments.begin(), arguments.end());
    try {
        app.parse(arguments);
        return {};
    } catch (const CLI::ParseError& error) {
        return error.what();
    }
}

std::filesystem::path write_config(const std::string& text) {
    const auto path = std::filesystem::path(::testing::TempDir()) / ("config-" + std::to_string(::getpid()) + ".toml");
    std::ofstream(path) << text;
    return path;
}

TEST(JobOptions, EveryOptionReachesItsField) {
    JobSpec spec;
    EXPECT_EQ(parse(spec, {"--particles",
                           "25M",
                           "--seed",
                           "7",
                           "--strategy",
                           "sets",
                           "--packing",
                           "maps",
                           "--particles-per-set",
                           "5e4",
                           "--hits-per-message",
                           "1k",
                           "--texel",
                           "0.05",
                           "--keep-hits",
                           "2M",
                           "--absorption",
                           "attenuate",
                           "--cutoff",
                           "1e-3",
                           "--cutoff-rule",
                           "plain",
                           "--name",
                           "hall",
                           "--priority",
                           "-3"}),
              "");
    JobSpec wanted;
    wanted.particles = 25'000'000;
    wanted.seed = 7;
    wanted.packing = Packing::maps;
    wanted.particles_per_set = 50'000;
    wanted.hits_per_message = 1'000;
    wanted.texel_m = 0.05;
    wanted.keep_hits = 2'000'000;
    wanted.absorption = Absorption::attenuate;
    wanted.cutoff = 1e-3;
    wanted.cutoff_rule = CutoffRule::plain;
    wanted.name = "hall";
    wanted.priority = -3;
    EXPECT_EQ(spec, wanted);
}

TEST(JobOptions, NothingSaidLeavesTheDefaults) {
    JobSpec spec;
    EXPECT_EQ(parse(spec, {}), "");
    EXPECT_EQ(spec, JobSpec());
}

TEST(JobOptions, SetsOfAutomaticSizeCanBeSaid) {
    JobSpec spec;
    spec.particles_per_set = 5;
    EXPECT_EQ(parse(spec, {"--particles-per-set", "auto"}), "");
    EXPECT_EQ(spec.particles_per_set, 0u);
}

TEST(JobOptions, WrongValuesAreToldWithTheirOption) {
    JobSpec spec;
    for (const auto& [option, value] : std::vector<std::pair<std::string, std::string>>{{"--particles", "many"},
                                                                                        {"--particles", "-5"},
                                                                                        {"--seed", "1.5"},
                                                                                        {"--packing", "zip"},
                                                                                        {"--strategy", "space"},
                                                                                        {"--particles-per-set", "0"},
                                                                                        {"--hits-per-message", "5e9"},
                                                                                        {"--texel", "nan"},
                                                                                        {"--absorption", "none"},
                                                                                        {"--priority", "1e10"}}) {
        const std::string sentence = parse(spec, {option, value});
        EXPECT_NE(sentence.find(option + ": '" + value + "'"), std::string::npos)
            << option << " " << value << ": " << sentence;
    }
}

TEST(JobOptions, CommandLineGoesBeforeEnvironmentAndThatBeforeTheFile) {
    const auto config = write_config("[run]\nparticles = \"3k\"\nseed = 3\npriority = 3\n");
    const Variable particles("LUMENFARM_PARTICLES", "2k");
    const Variable seed("LUMENFARM_SEED", "2");
    JobSpec spec;
    EXPECT_EQ(parse(spec, {"--particles", "1k"}, config), "");
    EXPECT_EQ(spec.particles, 1'000u);
    EXPECT_EQ(spec.seed, 2u);
    EXPECT_EQ(spec.priority, 3);
    std::filesystem::remove(config);
}

TEST(JobOptions, UnknownKeyInTheFileIsTold) {
    const auto config = write_config("[run]\nparticels = 5\n");
    JobSpec spec;
    EXPECT_NE(parse(spec, {}, config).find("particels"), std::string::npos);
    std::filesystem::remove(config);
}

TEST(JobOptions, WrongValueInTheEnvironmentIsTold) {
    const Variable keep("LUMENFARM_KEEP_HITS", "lots");
    JobSpec spec;
    EXPECT_NE(parse(spec, {}).find("--keep-hits: 'lots'"), std::string::npos);
}

TEST(Options, EnvironmentNamesFollowFromTheOptions) {
    EXPECT_EQ(environment_name("keep-hits"), "LUMENFARM_KEEP_HITS");
    EXPECT_EQ(environment_name("master"), "LUMENFARM_MASTER");
}

TEST(Options, FileInTheHomeFolderIsTheConfiguration) {
    const auto home = std::filesystem::path(::testing::TempDir()) / ("home-" + std::to_string(::getpid()));
    std::filesystem::create_directories(home / ".config/lumenfarm");
    const auto file = home / ".config/lumenfarm/config.toml";
    std::ofstream(file) << "master = \"10.0.0.1:7420\"\n";
    const Variable variable("HOME", home);
    EXPECT_EQ(default_config_file(), file);
    const Variable named("LUMENFARM_CONFIG", "/somewhere/else.toml");
    EXPECT_EQ(default_config_file(), "/somewhere/else.toml");
    std::filesystem::remove_all(home);
}

}  // namespace
}  // namespace lumenfarm
