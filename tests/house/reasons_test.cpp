// docs/operations.md lists every reason of every close, refusal and discard, and no others.
#include <gmock/gmock.h>

#include "master/discard.h"
#include "master/farm_counts.h"
#include "tests/house/text_rules.h"
#include "worker/discard.h"

#include <algorithm>
#include <map>
#include <regex>
#include <set>

namespace lumenfarm::house {
namespace {

const SourceFile& page() {
    static const SourceTree repository = read_repository(LUMENFARM_SOURCE_DIR);
    static const SourceFile found = *std::ranges::find(repository, "docs/operations.md", &SourceFile::path);
    return found;
}

/// The names that begin the rows of the table under the heading "### `group`: ...".
std::multiset<std::string> listed_under(const std::string& group) {
    std::multiset<std::string> names;
    bool inside = false;
    const std::regex row(R"(\| `([^`]*)` \|.*)");
    for (const std::string& line : page().lines) {
        if (line.starts_with("#")) inside = line.starts_with("### `" + group + "`");
        if (std::smatch match; inside && std::regex_match(line, match, row)) names.insert(match[1]);
    }
    return names;
}

template <class Reason>
std::multiset<std::string> names_of() {
    std::multiset<std::string> names;
    Tally<Reason>().each([&](Reason reason, std::uint64_t) { names.insert(std::string(name_of(reason))); });
    return names;
}

TEST(Reasons, EveryCountOfTheMasterIsListedUnderItsGroup) {
    std::map<std::string, std::multiset<std::string>> groups;
    for (const wire::ReasonCount& count : FarmCounts().listed()) groups[count.group].insert(count.reason);
    EXPECT_EQ(groups.size(), 7u);
    for (const auto& [group, names] : groups) EXPECT_EQ(listed_under(group), names) << group;
}

TEST(Reasons, EveryOneOfAWorkerIsListed) {
    EXPECT_EQ(listed_under("discarded"), names_of<worker::Discard>());
    EXPECT_EQ(listed_under("answers to results"), names_of<wire::Verdict>());
}

TEST(Reasons, EveryGoodbyeIsListed) { EXPECT_EQ(listed_under("goodbye"), names_of<wire::GoodbyeReason>()); }

TEST(Reasons, NamesFitAMessageAndAreNotUsedTwiceInOneGroup) {
    const auto all = FarmCounts().listed();
    EXPECT_LE(all.size(), limits::reason_counts_max);
    std::set<std::pair<std::string, std::string>> seen;
    for (const wire::ReasonCount& count : all) {
        EXPECT_TRUE(seen.insert({count.group, count.reason}).second) << count.reason;
        EXPECT_LE(std::max(count.group.size(), count.reason.size()), limits::reason_name_bytes_max) << count.reason;
    }
}

}  // namespace
}  // namespace lumenfarm::house
