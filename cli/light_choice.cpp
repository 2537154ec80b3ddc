#include "cli/light_choice.h"

#include "cli/number.h"
#include "common/scene/text.h"

#include <algorithm>
#include <vector>

namespace lumenfarm {
namespace {

constexpr std::size_t listed_max = 10;

std::string list_of(const Scene& scene, const std::vector<std::uint32_t>& numbers) {
    std::string list;
    const std::size_t listed = std::min(numbers.size(), listed_max);
    for (std::size_t i = 0; i < listed; ++i)
        list += (i == 0 ? "" : ", ") + std::to_string(numbers[i]) + " '" + scene.lights[numbers[i]].name + "'";
    if (numbers.size() > listed) list += " and " + std::to_string(numbers.size() - listed) + " more";
    return list;
}

}  // namespace

Result<std::uint32_t> choose_light(const Scene& scene, const std::string& wanted) {
    std::vector<std::uint32_t> all, named;
    for (std::uint32_t light = 0; light < scene.lights.size(); ++light) {
        all.push_back(light);
        if (scene.lights[light].name == wanted) named.push_back(light);
    }
    if (named.size() == 1) return named.front();
    const std::string quoted = "'" + clean_name(wanted) + "'";
    if (named.size() > 1)
        return bad_input("several lights are called " + quoted + "; say the number: " + list_of(scene, named));
    const auto number = parse_count(wanted);
    if (number && *number < all.size()) return static_cast<std::uint32_t>(*number);
    return bad_input("the scene has no light " + quoted + "; it has " + list_of(scene, all));
}

}  // namespace lumenfarm
