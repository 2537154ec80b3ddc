#include "cli/import/resource.h"

#include "common/scene/text.h"

#include <algorithm>

namespace lumenfarm::import {

Result<std::filesystem::path> resource_path(const std::filesystem::path& scene_file, const std::string& name) {
    const auto refuse = [&](const char* why) {
        return bad_input("'" + clean_name(scene_file.string()) + "' names the file '" +
                         clean_name(name.substr(0, 200)) + "', " + why);
    };
    std::string portable = name;
    std::replace(portable.begin(), portable.end(), '\\', '/');
    const std::filesystem::path relative(portable);
    if (name.empty() || name.find('\0') != std::string::npos) return refuse("which is no name of a file");
    if (portable.find("://") != std::string::npos) return refuse("which is an address; only files are read");
    if (relative.is_absolute() || (portable.size() > 1 && portable[1] == ':'))
        return refuse("which is absolute; files must lie in the scene's folder");
    for (const auto& part : relative)
        if (part == "..") return refuse("which leads out of the scene's folder");
    return scene_file.parent_path() / relative;
}

}  // namespace lumenfarm::import
