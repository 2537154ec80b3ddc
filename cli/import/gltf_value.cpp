#include "cli/import/gltf_value.h"

#include <cmath>

namespace lumenfarm::import {
namespace {

std::string text(double value) {
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, "%g", value);
    return buffer;
}

std::string range(double low, double high) { return "from " + text(low) + " to " + text(high); }

}  // namespace

const tinygltf::Value* member(const tinygltf::Value& value, const std::string& key) {
    return value.IsObject() && value.Has(key) ? &value.Get(key) : nullptr;
}

Result<double> number_member(const tinygltf::Value& value, const std::string& key, double otherwise, double low,
                             double high) {
    const tinygltf::Value* found = member(value, key);
    if (found == nullptr) return otherwise;
    if (!found->IsNumber()) return bad_input(key + " must be a number");
    const double number = found->GetNumberAsDouble();
    if (!(number >= low && number <= high))
        return bad_input(key + " is " + text(number) + "; it must lie " + range(low, high));
    return number;
}

std::optional<std::vector<double>> numbers(const tinygltf::Value& value) {
    if (!value.IsArray()) return std::nullopt;
    std::vector<double> list;
    for (std::size_t i = 0; i < value.ArrayLen(); ++i) {
        const tinygltf::Value& element = value.Get(static_cast<int>(i));
        if (!element.IsNumber() || !std::isfinite(element.GetNumberAsDouble())) return std::nullopt;
        list.push_back(element.GetNumberAsDouble());
    }
    return list;
}

Result<Vec3d> colour_member(const tinygltf::Value& value, const std::string& key, Vec3d otherwise, double low,
                            double high) {
    const tinygltf::Value* found = member(value, key);
    if (found == nullptr) return otherwise;
    const auto list = numbers(*found);
    if (!list || list->size() != 3) return bad_input(key + " must be an array of three numbers");
    for (const double component : *list)
        if (!(component >= low && component <= high))
            return bad_input(key + " has the component " + text(component) + "; it must lie " + range(low, high));
    return Vec3d{(*list)[0], (*list)[1], (*list)[2]};
}

}  // namespace lumenfarm::import
