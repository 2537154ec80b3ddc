#include "tests/house/text_rules.h"

#include <algorithm>
#include <regex>
#include <set>

namespace lumenfarm::house {
namespace {

namespace fs = std::filesystem;

bool is_code(const std::string& path) {
    const bool is_script = path.starts_with("deploy/") && fs::path(path).extension().empty();
    return is_cpp(path) || path.ends_with("CMakeLists.txt") || path.ends_with(".cmake") || path.ends_with(".py") ||
           is_script;
}

std::string at(const SourceFile& file, std::size_t line_index) {
    return file.path + ":" + std::to_string(line_index + 1) + ": ";
}

bool leads_outside(const std::string& target) {
    return target.starts_with('#') || target.find("://") != std::string::npos;
}

bool leads_to_file(const fs::path& root, const std::string& page, const std::string& target) {
    const std::string without_anchor = target.substr(0, target.find('#'));
    return fs::exists(root / fs::path(page).parent_path() / without_anchor);
}

}  // namespace

Findings length_findings(const SourceTree& files, std::size_t lines_max) {
    Findings findings;
    for (const SourceFile& file : files) {
        if (!is_code(file.path) || file.lines.size() <= lines_max) continue;
        findings.push_back(file.path + ": " + std::to_string(file.lines.size()) + " lines are more than " +
                           std::to_string(lines_max));
    }
    return findings;
}

Findings pattern_findings(const SourceTree& files, const std::string& pattern, const std::string& what) {
    const std::regex expression(pattern);
    Findings findings;
    for (const SourceFile& file : files) {
        for (std::size_t i = 0; i < file.lines.size(); ++i) {
            std::smatch match;
            if (!std::regex_search(file.lines[i], match, expression)) continue;
            findings.push_back(at(file, i) + what + " '" + match.str() + "'");
        }
    }
    return findings;
}

Findings unfinished_work_findings(const SourceTree& files) {
    // The words are written in two halves, or this file would find itself.
    return pattern_findings(files,
                            R"(\b(TO)"
                            R"(DO|FIX)"
                            R"(ME|XX)"
                            R"(X)\b)",
                            "a mark of unfinished work");
}

Findings machine_path_findings(const SourceTree& files) {
    const std::string folders = R"((^|[^\w.~/-])/(ho)"
                                R"(me|ro)"
                                R"(ot|wo)"
                                R"(rk|Us)"
                                R"(ers|tm)"
                                R"(p)/\w)";
    return pattern_findings(files, folders, "a path of one machine");
}

Findings broken_link_findings(const SourceTree& files, const fs::path& root) {
    static const std::regex link(R"re(\]\(([^)\s]+)\))re");
    Findings findings;
    for (const SourceFile& file : files) {
        if (!file.path.ends_with(".md")) continue;
        for (std::size_t i = 0; i < file.lines.size(); ++i) {
            const std::string& line = file.lines[i];
            for (std::sregex_iterator match(line.begin(), line.end(), link), end; match != end; ++match) {
                const std::string target = (*match)[1];
                if (leads_outside(target) || leads_to_file(root, file.path, target)) continue;
                findings.push_back(at(file, i) + "there is no file for the link '" + target + "'");
            }
        }
    }
    return findings;
}

Findings unnamed_folder_findings(const SourceTree& sources, const SourceFile& page) {
    std::set<std::string> folders;
    for (const SourceFile& file : sources) folders.insert(fs::path(file.path).parent_path().generic_string());
    Findings findings;
    for (const std::string& folder : folders) {
        const auto names_it = [&](const std::string& line) {
            return line.find("`" + folder + "/`") != std::string::npos;
        };
        if (std::ranges::none_of(page.lines, names_it))
            findings.push_back(page.path + ": does not name `" + folder + "/`");
    }
    return findings;
}

Findings unbuilt_test_findings(const SourceTree& repository, const SourceFile& tests_cmake_lists) {
    std::set<std::string> folders;
    for (const SourceFile& file : repository) {
        if (!file.path.starts_with("tests/") || !file.path.ends_with(".cpp")) continue;
        const std::string below = file.path.substr(std::string("tests/").size());
        folders.insert(below.substr(0, below.rfind('/')));
    }
    Findings findings;
    for (const std::string& folder : folders) {
        const std::regex entry(R"(^(lumenfarm_tests|add_subdirectory)\()" + folder + R"([ )])");
        const auto builds_it = [&](const std::string& line) { return std::regex_search(line, entry); };
        if (std::ranges::none_of(tests_cmake_lists.lines, builds_it))
            findings.push_back(tests_cmake_lists.path + ": does not build tests/" + folder);
    }
    return findings;
}

}  // namespace lumenfarm::house
