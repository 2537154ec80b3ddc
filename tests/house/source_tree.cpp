#include "tests/house/source_tree.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <regex>
#include <sstream>

namespace lumenfarm::house {
namespace {

namespace fs = std::filesystem;

constexpr std::array folders{".ci",    "cli",   "cmake",  "common", "deploy", "docs",
                             "master", "proto", "scenes", "tests",  "worker"};
constexpr std::array programs{"cli/", "common/", "master/", "proto/", "worker/"};
// Foreign bytes on purpose, not our text: the fuzz targets' inputs.
constexpr const char* corpus_folder = "tests/fuzz/corpus/";

std::string text_of(const fs::path& path) {
    std::ifstream stream(path, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
}

void append_if_text(SourceTree& tree, const fs::path& root, const fs::path& path) {
    const std::string relative = fs::relative(path, root).generic_string();
    if (relative.starts_with(corpus_folder)) return;
    const std::string text = text_of(path);
    const bool is_binary = text.find('\0') != std::string::npos;
    if (!is_binary) tree.push_back(file_of(relative, text));
}

}  // namespace

SourceFile file_of(const std::string& path, const std::string& text) {
    SourceFile file{path, {}};
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) file.lines.push_back(line);
    return file;
}

SourceTree read_repository(const fs::path& root) {
    SourceTree tree;
    for (const fs::directory_entry& entry : fs::directory_iterator(root)) {
        // in a worktree .git is a file, which says where the repository lies
        if (entry.is_regular_file() && entry.path().filename() != ".git") append_if_text(tree, root, entry.path());
    }
    for (const char* folder : folders) {
        if (!fs::exists(root / folder)) continue;
        for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / folder)) {
            if (entry.is_regular_file()) append_if_text(tree, root, entry.path());
        }
    }
    std::ranges::sort(tree, {}, &SourceFile::path);
    return tree;
}

SourceTree program_sources(const SourceTree& repository) {
    SourceTree sources;
    std::ranges::copy_if(repository, std::back_inserter(sources), [](const SourceFile& file) {
        const auto holds = [&](const char* folder) { return file.path.starts_with(folder); };
        return is_cpp(file.path) && std::ranges::any_of(programs, holds);
    });
    return sources;
}

bool is_cpp(const std::string& path) { return path.ends_with(".h") || path.ends_with(".cpp"); }

std::vector<Include> includes_of(const SourceFile& file) {
    static const std::regex pattern(R"re(^\s*#\s*include\s*(["<])([^">]+)[">])re");
    std::vector<Include> includes;
    for (std::size_t i = 0; i < file.lines.size(); ++i) {
        std::smatch match;
        if (std::regex_search(file.lines[i], match, pattern)) includes.push_back({match[2], match[1] == "\"", i + 1});
    }
    return includes;
}

}  // namespace lumenfarm::house
