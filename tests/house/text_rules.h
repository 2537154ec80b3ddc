// What no text of the repository may hold, and what its pages must hold.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "tests/house/room_rules.h"
#include "tests/house/source_tree.h"

namespace lumenfarm::house {

inline constexpr std::size_t file_lines_max = 500;

/// Files of code (C++, CMake, scripts, Python) longer than `lines_max`.
[[nodiscard]] Findings length_findings(const SourceTree& files, std::size_t lines_max);

/// Lines on which the regular expression is found.
[[nodiscard]] Findings pattern_findings(const SourceTree& files, const std::string& pattern, const std::string& what);

/// Marks of unfinished work.
[[nodiscard]] Findings unfinished_work_findings(const SourceTree& files);

/// Absolute paths into one person's machine: home folders, work folders, scratch folders.
[[nodiscard]] Findings machine_path_findings(const SourceTree& files);

/// Relative links of the Markdown pages that lead to no file under `root`.
[[nodiscard]] Findings broken_link_findings(const SourceTree& files, const std::filesystem::path& root);

/// Folders that hold sources of the programs and that the page does not name as `folder/`.
[[nodiscard]] Findings unnamed_folder_findings(const SourceTree& sources, const SourceFile& page);

/// Folders under tests/ that hold *.cpp and that neither a lumenfarm_tests nor an add_subdirectory line of the list
/// names: their tests would never run.
[[nodiscard]] Findings unbuilt_test_findings(const SourceTree& repository, const SourceFile& tests_cmake_lists);

}  // namespace lumenfarm::house
