// The repository's own files as text, for tests that check the house itself.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace lumenfarm::house {

/// One text file. `path` is relative to the repository's root, with forward slashes: "common/net/connection.cpp".
struct SourceFile {
    std::string path;
    std::vector<std::string> lines;
};

using SourceTree = std::vector<SourceFile>;

/// One `#include` line. `header` is the text between the quotes or angle brackets.
struct Include {
    std::string header;
    bool quoted = false;
    std::size_t line = 0;
};

/// A file from a snippet of text, for the tests of the checks themselves.
[[nodiscard]] SourceFile file_of(const std::string& path, const std::string& text);

/// Every text file of the repository, sorted by path: its folders (build trees and results are no part of it) and the
/// files at its root.
[[nodiscard]] SourceTree read_repository(const std::filesystem::path& root);

/// The *.h and *.cpp files of the programs, tests left out.
[[nodiscard]] SourceTree program_sources(const SourceTree& repository);

/// Whether the path ends in .h or .cpp.
[[nodiscard]] bool is_cpp(const std::string& path);

[[nodiscard]] std::vector<Include> includes_of(const SourceFile& file);

}  // namespace lumenfarm::house
