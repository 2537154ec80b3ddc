#include "common/scene/job_spec.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace lumenfarm {
namespace {

TEST(JobSpec, DefaultsAreValid) { EXPECT_TRUE(validate(JobSpec{})); }

TEST(JobSpec, EveryFieldOutOfRangeIsRefusedByItsName) {
    const struct {
        const char* says;
        std::function<void(JobSpec&)> make;
    } faults[] = {
        {"particles is 0", [](JobSpec& s) { s.particles = 0; }},
        {"particles is 4294967297", [](JobSpec& s) { s.particles = 4294967297; }},
        {"absorption", [](JobSpec& s) { s.absorption = static_cast<Absorption>(2); }},
        {"cutoff rule", [](JobSpec& s) { s.cutoff_rule = static_cast<CutoffRule>(2); }},
        {"cutoff is 0", [](JobSpec& s) { s.cutoff = 0; }},
        {"cutoff is 1", [](JobSpec& s) { s.cutoff = 1; }},
        {"cutoff is nan", [](JobSpec& s) { s.cutoff = std::nan(""); }},
        {"texel is -", [](JobSpec& s) { s.texel_m = -1; }},
        {"texel is inf", [](JobSpec& s) { s.texel_m = INFINITY; }},
        {"keep-hits", [](JobSpec& s) { s.keep_hits = 1ull << 40; }},
        {"strategy", [](JobSpec& s) { s.strategy = static_cast<Strategy>(2); }},
        {"packing", [](JobSpec& s) { s.packing = static_cast<Packing>(3); }},
        {"particles-per-set", [](JobSpec& s) { s.particles_per_set = 1ull << 40; }},
        {"hits-per-message is 0", [](JobSpec& s) { s.hits_per_message = 0; }},
        {"hits-per-message", [](JobSpec& s) { s.hits_per_message = 60'001; }},
        {"priority is -2147483648", [](JobSpec& s) { s.priority = -2147483647 - 1; }},
        {"name", [](JobSpec& s) { s.name = "a\tb"; }},
        {"name", [](JobSpec& s) { s.name = std::string(2000, 'x'); }},
    };
    for (const auto& fault : faults) {
        JobSpec spec;
        fault.make(spec);
        const auto result = validate(spec);
        ASSERT_FALSE(result) << fault.says;
        EXPECT_EQ(result.error().code, ErrorCode::bad_input);
        EXPECT_NE(result.error().sentence.find(fault.says), std::string::npos) << result.error().sentence;
    }
}

TEST(JobSpec, TexelIsAsAskedForOrA64thOfTheDiagonal) {
    JobSpec spec;
    EXPECT_EQ(texel_in_force_m(spec, 6.4), 0.1);
    spec.texel_m = 0.25;
    EXPECT_EQ(texel_in_force_m(spec, 6.4), 0.25);
}

}  // namespace
}  // namespace lumenfarm
