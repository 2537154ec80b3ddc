// The checks themselves: each finds what it is for in a small snippet, and lets the neighbouring right thing pass.
#include <gmock/gmock.h>

#include "tests/house/room_rules.h"
#include "tests/house/text_rules.h"

namespace lumenfarm::house {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

const std::vector<std::string> order{"common/support", "common/scene", "common/solution", "common/imaging",
                                     "common/net"};

Findings findings_for(const std::string& path, const std::string& header) {
    return room_order_findings({file_of(path, "#include \"" + header + "\"\n")}, order);
}

TEST(RoomOrderCheck, ReadsTheOrderFromCMake) {
    const SourceFile file =
        file_of("common/CMakeLists.txt", "# comment\nadd_subdirectory(support)\nadd_subdirectory(math)\n");
    EXPECT_THAT(common_rooms_in_order(file), ElementsAre("common/support", "common/math"));
}

TEST(RoomOrderCheck, ARoomIsItsFolderAndCliKeepsItsOwnFiles) {
    EXPECT_EQ(room_of("common/net/listener.h"), "common/net");
    EXPECT_EQ(room_of("cli/import/mesh.h"), "cli/import");
    EXPECT_EQ(room_of("cli/main.cpp"), "cli");
    EXPECT_EQ(room_of("master/dashboard/page.h"), "master/dashboard");
    EXPECT_EQ(room_of("listener.h"), "");
}

TEST(RoomOrderCheck, DownTheOrderIsAllowedAndUpIsFound) {
    EXPECT_THAT(findings_for("common/scene/a.h", "common/support/b.h"), IsEmpty());
    EXPECT_THAT(findings_for("common/support/b.h", "common/scene/a.h"),
                ElementsAre(HasSubstr("common/support/b.h:1: ")));
}

TEST(RoomOrderCheck, CommonAndProtoNeverSeeThePrograms) {
    for (const char* program : {"master/a.h", "worker/a.h", "cli/a.h", "cli/import/a.h", "tests/a.h"}) {
        EXPECT_THAT(findings_for("common/net/a.cpp", program), SizeIs(1)) << program;
        EXPECT_THAT(findings_for("proto/a.cpp", program), SizeIs(1)) << program;
    }
}

TEST(RoomOrderCheck, OnlyTheNetRoomSeesProto) {
    EXPECT_THAT(findings_for("common/net/a.cpp", "proto/frame.h"), IsEmpty());
    EXPECT_THAT(findings_for("common/imaging/a.cpp", "proto/frame.h"), SizeIs(1));
    EXPECT_THAT(findings_for("proto/a.cpp", "common/solution/a.h"), IsEmpty());
    EXPECT_THAT(findings_for("proto/a.cpp", "common/imaging/a.h"), SizeIs(1));
    EXPECT_THAT(findings_for("proto/a.cpp", "common/net/a.h"), SizeIs(1));
}

TEST(RoomOrderCheck, ProgramsNeverSeeEachOtherButCliSeesTheDaemons) {
    EXPECT_THAT(findings_for("master/a.cpp", "worker/a.h"), SizeIs(1));
    EXPECT_THAT(findings_for("worker/a.cpp", "master/a.h"), SizeIs(1));
    EXPECT_THAT(findings_for("worker/a.cpp", "cli/a.h"), SizeIs(1));
    EXPECT_THAT(findings_for("worker/paced/a.cpp", "worker/a.h"), IsEmpty());
    EXPECT_THAT(findings_for("worker/a.cpp", "worker/paced/a.h"), SizeIs(1));
    EXPECT_THAT(findings_for("cli/run.cpp", "master/a.h"), IsEmpty());
    EXPECT_THAT(findings_for("cli/run.cpp", "tests/a.h"), SizeIs(1));
    EXPECT_THAT(findings_for("cli/import/a.cpp", "master/a.h"), SizeIs(1));
    EXPECT_THAT(findings_for("cli/import/a.cpp", "cli/products/a.h"), SizeIs(1));
}

TEST(RoomOrderCheck, AnIncludeThatIsNotFromTheRootIsFound) {
    EXPECT_THAT(findings_for("master/a.cpp", "a.h"), SizeIs(1));
    EXPECT_THAT(findings_for("common/scene/a.cpp", "../support/b.h"), SizeIs(1));
}

TEST(RoomOrderCheck, ARoomThatCMakeDoesNotNameIsFound) {
    EXPECT_THAT(findings_for("master/a.cpp", "common/support/a.h"), IsEmpty());
    EXPECT_THAT(findings_for("common/unknown/a.cpp", "common/support/a.h"), SizeIs(1));
}

TEST(FenceCheck, FindsALibraryOutsideItsFilesOnly) {
    const Fence fence{"Asio", {"boost/asio"}, "common/net/.*|.*_session\\.(h|cpp)"};
    const std::string text = "#include <vector>\n  #  include <boost/asio/post.hpp>\n";
    EXPECT_THAT(fence_findings({file_of("master/ledger.cpp", text)}, fence),
                ElementsAre(HasSubstr("master/ledger.cpp:2: ")));
    EXPECT_THAT(fence_findings({file_of("common/net/listener.cpp", text)}, fence), IsEmpty());
    EXPECT_THAT(fence_findings({file_of("master/server_session.cpp", text)}, fence), IsEmpty());
    EXPECT_THAT(files_that_include({file_of("master/ledger.cpp", text)}, fence, "master/"),
                ElementsAre("master/ledger.cpp"));
    EXPECT_THAT(files_that_include({file_of("master/ledger.cpp", text)}, fence, "worker/"), IsEmpty());
}

TEST(LengthCheck, CountsLinesOfCodeAndLeavesPagesAlone) {
    const std::string three_lines = "a\nb\nc\n";
    EXPECT_THAT(length_findings({file_of("master/a.cpp", three_lines)}, 3), IsEmpty());
    EXPECT_THAT(length_findings({file_of("master/a.cpp", three_lines)}, 2), SizeIs(1));
    EXPECT_THAT(length_findings({file_of("deploy/setup", three_lines)}, 2), SizeIs(1));
    EXPECT_THAT(length_findings({file_of("docs/wire.md", three_lines)}, 2), IsEmpty());
}

TEST(UnfinishedWorkCheck, FindsTheMarksAsWholeWords) {
    const std::string mark = std::string("TO") + "DO";
    EXPECT_THAT(unfinished_work_findings({file_of("a.cpp", "int a;\n// " + mark + ": b\n")}),
                ElementsAre(HasSubstr("a.cpp:2: ")));
    EXPECT_THAT(unfinished_work_findings({file_of("a.cpp", "// " + std::string("FIX") + "ME\n")}), SizeIs(1));
    EXPECT_THAT(unfinished_work_findings({file_of("a.cpp", "int MAS" + mark + "NT;\n")}), IsEmpty());
}

TEST(MachinePathCheck, FindsHomesAndScratchFoldersButNotSystemPaths) {
    const auto findings = [](const std::string& line) { return machine_path_findings({file_of("a.md", line + "\n")}); };
    const std::string slash = "/";
    for (const char* folder : {"home", "work", "root", "tmp", "Users"}) {
        EXPECT_THAT(findings("see " + slash + folder + "/scene.glb"), SizeIs(1)) << folder;
        EXPECT_THAT(findings("see \"" + slash + folder + "/scene.glb\""), SizeIs(1)) << folder;
    }
    EXPECT_THAT(findings("/etc/lumenfarm/master.toml and out/home/a and https://example.org/work/a"), IsEmpty());
}

TEST(LinkCheck, FindsALinkThatLeadsNowhere) {
    const std::filesystem::path root = LUMENFARM_SOURCE_DIR;
    const auto findings = [&](const std::string& link) {
        return broken_link_findings({file_of("docs/page.md", "see [this](" + link + ")\n")}, root);
    };
    EXPECT_THAT(findings("no_such_page.md"), ElementsAre(HasSubstr("no_such_page.md")));
    EXPECT_THAT(findings("../README.md"), IsEmpty());
    EXPECT_THAT(findings("../README.md#licence"), IsEmpty());
    EXPECT_THAT(findings("https://example.org/a"), IsEmpty());
}

TEST(FolderCheck, FindsAFolderThatThePageDoesNotName) {
    const SourceTree sources{file_of("common/net/a.cpp", ""), file_of("common/math/a.cpp", "")};
    const SourceFile page = file_of("docs/architecture.md", "| `common/net/` | sockets |\n");
    EXPECT_THAT(unnamed_folder_findings(sources, page), ElementsAre(HasSubstr("`common/math/`")));
}

TEST(TestFolderCheck, FindsAFolderThatIsNotBuilt) {
    const SourceFile list = file_of("tests/CMakeLists.txt", "lumenfarm_tests(net LINK a)\nadd_subdirectory(bench)\n");
    const auto findings = [&](const std::string& path) { return unbuilt_test_findings({file_of(path, "")}, list); };
    EXPECT_THAT(findings("tests/net/a_test.cpp"), IsEmpty());
    EXPECT_THAT(findings("tests/bench/a.cpp"), IsEmpty());
    EXPECT_THAT(findings("tests/octree/a_test.cpp"), ElementsAre(HasSubstr("tests/octree")));
    EXPECT_THAT(findings("tests/octree/a.h"), IsEmpty());
}

TEST(SourceTreeCheck, ReadsTheFilesOfThisRepository) {
    const SourceTree repository = read_repository(LUMENFARM_SOURCE_DIR);
    std::vector<std::string> paths;
    for (const SourceFile& file : repository) paths.push_back(file.path);
    EXPECT_THAT(paths, Contains("tests/house/checks_test.cpp"));
    EXPECT_THAT(paths, Contains("README.md"));
    EXPECT_THAT(paths, Contains("deploy/setup"));
    EXPECT_FALSE(program_sources(repository).empty());
}

}  // namespace
}  // namespace lumenfarm::house
