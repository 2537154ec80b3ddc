#include "tests/house/room_rules.h"

#include <algorithm>
#include <optional>
#include <regex>

namespace lumenfarm::house {
namespace {

constexpr const char* deepest_room_that_proto_sees = "common/solution";

std::optional<std::size_t> position(const std::vector<std::string>& order, const std::string& room) {
    const auto found = std::ranges::find(order, room);
    if (found == order.end()) return std::nullopt;
    return static_cast<std::size_t>(found - order.begin());
}

bool is_common(const std::string& room) { return room.starts_with("common/"); }

bool common_may_include(const std::vector<std::string>& order, const std::string& from, const std::string& to) {
    if (to == "proto") return from == "common/net";
    const auto from_place = position(order, from);
    const auto to_place = position(order, to);
    return from_place && to_place && *to_place < *from_place;
}

bool proto_may_include(const std::vector<std::string>& order, const std::string& to) {
    const auto deepest = position(order, deepest_room_that_proto_sees);
    const auto place = position(order, to);
    return deepest && place && *place <= *deepest;
}

bool may_include(const std::vector<std::string>& order, const std::string& from, const std::string& to) {
    if (from == to) return true;
    if (is_common(from)) return common_may_include(order, from, to);
    if (from == "proto") return proto_may_include(order, to);
    if (from == "relay")
        return is_common(to) || to == "proto" || to == "master" || to == "worker" || to.starts_with("master/");
    if (from == "master" || from == "worker" || from.starts_with("master/"))
        return is_common(to) || to == "proto" || (from == "master" && to.starts_with("master/"));
    if (from == "worker/paced") return is_common(to) || to == "proto" || to == "worker";
    if (from == "cli/import" || from == "cli/products") return is_common(to);
    if (from == "cli/bench") return is_common(to) || to == "proto";
    if (from == "cli") return to != "tests";
    return false;
}

std::string finding(const SourceFile& file, const Include& include, const std::string& sentence) {
    return file.path + ":" + std::to_string(include.line) + ": " + sentence;
}

bool belongs_to(const Fence& fence, const Include& include) {
    return std::ranges::any_of(fence.header_prefixes,
                               [&](const std::string& prefix) { return include.header.starts_with(prefix); });
}

}  // namespace

std::string room_of(const std::string& path) {
    const std::size_t first = path.find('/');
    if (first == std::string::npos) return "";
    const std::string top = path.substr(0, first);
    const std::size_t second = path.find('/', first + 1);
    const bool has_rooms = top == "common" || top == "cli" || top == "master" || top == "worker";
    return has_rooms && second != std::string::npos ? path.substr(0, second) : top;
}

std::vector<std::string> common_rooms_in_order(const SourceFile& common_cmake_lists) {
    static const std::regex pattern(R"re(^\s*add_subdirectory\((\w+)\))re");
    std::vector<std::string> rooms;
    for (const std::string& line : common_cmake_lists.lines) {
        std::smatch match;
        if (std::regex_search(line, match, pattern)) rooms.push_back("common/" + match[1].str());
    }
    return rooms;
}

Findings room_order_findings(const SourceTree& sources, const std::vector<std::string>& common_order) {
    Findings findings;
    for (const SourceFile& file : sources) {
        for (const Include& include : includes_of(file)) {
            if (!include.quoted) continue;
            const std::string from = room_of(file.path);
            const std::string to = room_of(include.header);
            if (may_include(common_order, from, to)) continue;
            if (file.path == "master/main.cpp" && to == "relay") continue;  // lumenfarm-master may be one
            findings.push_back(finding(file, include, from + " may not include \"" + include.header + "\""));
        }
    }
    return findings;
}

Findings fence_findings(const SourceTree& sources, const Fence& fence) {
    const std::regex allowed(fence.allowed_files);
    Findings findings;
    for (const SourceFile& file : sources) {
        if (std::regex_match(file.path, allowed)) continue;
        for (const Include& include : includes_of(file)) {
            if (!belongs_to(fence, include)) continue;
            findings.push_back(
                finding(file, include, "<" + include.header + "> is " + fence.library + ", which has its place"));
        }
    }
    return findings;
}

std::vector<std::string> files_that_include(const SourceTree& sources, const Fence& fence, const std::string& folder) {
    std::vector<std::string> paths;
    for (const SourceFile& file : sources) {
        const std::vector<Include> includes = includes_of(file);
        const bool uses =
            std::ranges::any_of(includes, [&](const Include& include) { return belongs_to(fence, include); });
        if (uses && file.path.starts_with(folder)) paths.push_back(file.path);
    }
    return paths;
}

}  // namespace lumenfarm::house
