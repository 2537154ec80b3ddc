// Which room may include which, and which library belongs to which files. docs/architecture.md explains why.
#pragma once

#include <string>
#include <vector>

#include "tests/house/source_tree.h"

namespace lumenfarm::house {

/// Sentences "path:line: what is wrong"; empty where the rule holds.
using Findings = std::vector<std::string>;

/// The room of a path: "common/net", "proto", "master", "cli/import", "tests". A file of the folder cli itself is in
/// "cli".
[[nodiscard]] std::string room_of(const std::string& path);

/// The rooms of common/ in the order of the data, read from the add_subdirectory lines of common/CMakeLists.txt.
[[nodiscard]] std::vector<std::string> common_rooms_in_order(const SourceFile& common_cmake_lists);

/// Every quoted include must name a file from the repository's root, and go one way:
/// - a room of common sees the rooms of common above it; common/net sees proto too, no other room of common does;
/// - proto sees common down to common/solution;
/// - master and worker see common and proto, never each other, never cli; worker/paced sees worker;
/// - cli/import and cli/products see common, never a daemon or each other;
/// - cli sees everything but tests.
[[nodiscard]] Findings room_order_findings(const SourceTree& sources, const std::vector<std::string>& common_order);

/// A library that only some files may include.
struct Fence {
    std::string library;
    /// A header belongs to the library if it starts with one of these.
    std::vector<std::string> header_prefixes;
    /// A regular expression that the whole path of an including file must match.
    std::string allowed_files;
};

[[nodiscard]] Findings fence_findings(const SourceTree& sources, const Fence& fence);

/// Files that include the library, of those in the folder; to check that there is one.
[[nodiscard]] std::vector<std::string> files_that_include(const SourceTree& sources, const Fence& fence,
                                                          const std::string& folder);

}  // namespace lumenfarm::house
