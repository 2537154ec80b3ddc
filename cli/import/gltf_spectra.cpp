#include "cli/import/gltf_spectra.h"

#include "cli/import/gltf_value.h"
#include "cli/import/optics.h"
#include "common/support/limits.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace lumenfarm::import {
namespace {

constexpr std::size_t points_max = 10'000;

struct Point {
    double nm, value;
};

/// Linear between the points; the end values continue.
Spectrum sample(const std::vector<Point>& points) {
    Spectrum spectrum;
    std::size_t next = 0;
    for (std::size_t i = 0; i < spectrum_samples; ++i) {
        const double nm = wavelength_min_nm + sample_step_nm * static_cast<double>(i);
        while (next < points.size() && points[next].nm <= nm) ++next;
        double value = next == 0 ? points.front().value : points[next - 1].value;
        if (next > 0 && next < points.size()) {
            const Point low = points[next - 1], high = points[next];
            value = low.value + (nm - low.nm) / (high.nm - low.nm) * (high.value - low.value);
        }
        spectrum.samples[i] = static_cast<float>(value);
    }
    return spectrum;
}

Error refuse(const std::string& key, const std::string& why) {
    return bad_input("extras.lumenfarm_spectra." + key + " " + why);
}

Result<Spectrum> read_points(const tinygltf::Value& list, const std::string& key, double low, double high) {
    std::vector<Point> points;
    if (!list.IsArray() || list.ArrayLen() == 0 || list.ArrayLen() > points_max)
        return refuse(key, "must be an array of 1 to 10000 pairs [nm, value]");
    for (std::size_t i = 0; i < list.ArrayLen(); ++i) {
        const auto pair = numbers(list.Get(static_cast<int>(i)));
        const std::string who = "has at place " + std::to_string(i);
        if (!pair || pair->size() != 2) return refuse(key, who + " something else than a pair of numbers [nm, value]");
        const Point point{(*pair)[0], (*pair)[1]};
        if (!points.empty() && point.nm <= points.back().nm)
            return refuse(key, who + " the wavelength " + std::to_string(point.nm) + " nm, which does not increase");
        if (!(point.value >= low && point.value <= high))
            return refuse(key, who + " the value " + std::to_string(point.value) + "; it must lie from " +
                                   std::to_string(low) + " to " + std::to_string(high));
        points.push_back(point);
    }
    return sample(points);
}

/// {"sellmeier": {"B": [..], "C": [..]}} or points.
Result<Spectrum> read_index(const tinygltf::Value& value) {
    const tinygltf::Value* formula = member(value, "sellmeier");
    if (formula == nullptr) return read_points(value, "refractive_index", 1, limits::refractive_index_max);
    std::array<std::array<double, 3>, 2> terms{};
    for (std::size_t which = 0; which < 2; ++which) {
        const tinygltf::Value* list = member(*formula, which == 0 ? "B" : "C");
        const auto given = list == nullptr ? std::nullopt : numbers(*list);
        if (!given || given->size() != 3)
            return refuse("refractive_index.sellmeier", "must have B and C, three numbers each");
        std::copy(given->begin(), given->end(), terms[which].begin());
    }
    const Spectrum n = sellmeier_index(terms[0], terms[1]);
    for (const float sample : n.samples)
        if (!(sample >= 1 && sample <= limits::refractive_index_max))
            return refuse("refractive_index.sellmeier",
                          "gives an index of " + std::to_string(sample) + ", which is not from 1 to 10");
    return n;
}

Result<void> read_points_member(const tinygltf::Value& block, const char* key, double high,
                                std::optional<Spectrum>& into) {
    const tinygltf::Value* given = member(block, key);
    if (given == nullptr) return {};
    const auto spectrum = read_points(*given, key, 0, high);
    if (!spectrum) return spectrum.error();
    into = *spectrum;
    return {};
}

Result<void> check_keys(const tinygltf::Value& block) {
    constexpr std::array<std::string_view, 7> known{"diffuse",          "mirror",          "transmission", "emission",
                                                    "refractive_index", "luminance_cd_m2", "distribution"};
    for (const std::string& key : block.Keys())
        if (std::find(known.begin(), known.end(), key) == known.end()) return refuse(key, "is not known");
    return {};
}

}  // namespace

Result<GivenSpectra> read_given_spectra(const tinygltf::Value& extras) {
    GivenSpectra given;
    const tinygltf::Value* block = member(extras, "lumenfarm_spectra");
    if (block == nullptr) return given;
    if (!block->IsObject()) return bad_input("extras.lumenfarm_spectra must be an object");
    if (auto r = check_keys(*block); !r) return r.error();
    if (auto r = read_points_member(*block, "diffuse", 1, given.diffuse); !r) return r.error();
    if (auto r = read_points_member(*block, "mirror", 1, given.mirror); !r) return r.error();
    if (auto r = read_points_member(*block, "transmission", 1, given.transmission); !r) return r.error();
    if (auto r = read_points_member(*block, "emission", limits::light_sample_max, given.emission); !r) return r.error();
    if (given.emission && *std::max_element(given.emission->samples.begin(), given.emission->samples.end()) <= 0)
        return refuse("emission", "is zero everywhere from 380 to 780 nm");
    if (const tinygltf::Value* index = member(*block, "refractive_index")) {
        const auto spectrum = read_index(*index);
        if (!spectrum) return spectrum.error();
        given.refractive_index = *spectrum;
    }
    if (member(*block, "luminance_cd_m2") != nullptr) {
        const auto luminance = number_member(*block, "luminance_cd_m2", 0, 0, limits::photometric_max);
        if (!luminance) return refuse(luminance.error().sentence, "[cd/m2]");
        given.luminance_cd_m2 = *luminance;
    }
    if (const tinygltf::Value* distribution = member(*block, "distribution")) {
        if (!distribution->IsString() || distribution->Get<std::string>() != "lambertian")
            return refuse("distribution", "must be \"lambertian\"");
        given.lambertian = true;
    }
    return given;
}

}  // namespace lumenfarm::import
