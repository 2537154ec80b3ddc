// The rules of the house, read from the sources as they are. A failure names file and line.
#include <gmock/gmock.h>

#include <algorithm>
#include <regex>

#include "tests/house/room_rules.h"
#include "tests/house/text_rules.h"

namespace lumenfarm::house {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

const std::filesystem::path root = LUMENFARM_SOURCE_DIR;

const SourceTree& repository() {
    static const SourceTree tree = read_repository(root);
    return tree;
}

const SourceTree& sources() {
    static const SourceTree tree = program_sources(repository());
    return tree;
}

const SourceFile& file_at(const std::string& path) {
    const auto found = std::ranges::find(repository(), path, &SourceFile::path);
    EXPECT_NE(found, repository().end()) << path;
    return *found;
}

/// The thin shells around the state machines, beside every *_session: the only files that know a socket or a clock.
const std::string shells =
    ".*_session\\.(h|cpp)|master/dashboard/.*|.*/main\\.cpp|master/master_server\\.(h|cpp)"
    "|worker/worker_client\\.(h|cpp)|relay/relay_server\\.(h|cpp)";

const Fence embree{"Embree", {"embree3/", "embree4/"}, "common/(transport|imaging)/.*"};

TEST(House, RoomsIncludeOnlyWhatStandsAboveThem) {
    const std::vector<std::string> order = common_rooms_in_order(file_at("common/CMakeLists.txt"));
    ASSERT_GE(order.size(), 9u);
    EXPECT_THAT(room_order_findings(sources(), order), IsEmpty());
}

TEST(House, SocketsStayInTheNetRoomAndTheShells) {
    const Fence fence{
        "a socket library", {"boost/asio", "boost/beast", "sys/socket.h", "netinet/"}, "common/net/.*|" + shells};
    EXPECT_THAT(fence_findings(sources(), fence), IsEmpty());
}

TEST(House, EmbreeIsCalledFromOneFileOfTransport) {
    EXPECT_THAT(fence_findings(sources(), embree), IsEmpty());
    EXPECT_THAT(files_that_include(sources(), embree, "common/transport/"), SizeIs(1));
    EXPECT_LE(files_that_include(sources(), embree, "common/imaging/").size(), 1u);
}

TEST(House, BoostSerializationStaysInProto) {
    const Fence fence{"Boost.Serialization", {"boost/archive/", "boost/serialization/"}, "proto/.*"};
    EXPECT_THAT(fence_findings(sources(), fence), IsEmpty());
}

TEST(House, SQLiteStaysInOneFile) {
    const Fence fence{"SQLite", {"sqlite3.h"}, "master/disk/database\\.cpp"};
    EXPECT_THAT(fence_findings(sources(), fence), IsEmpty());
}

TEST(House, SystemdIsToldFromOneFile) {
    const Fence fence{"libsystemd", {"systemd/"}, "common/service/service_manager\\.cpp"};
    EXPECT_THAT(fence_findings(sources(), fence), IsEmpty());
}

TEST(House, ProcessesAreStartedFromOneFile) {
    const Fence fence{"Boost.Process", {"boost/process"}, "cli/bench/daemon\\.cpp"};
    EXPECT_THAT(fence_findings(sources(), fence), IsEmpty());
}

TEST(House, OpenImageIOStaysInImagingAndImport) {
    const Fence fence{"OpenImageIO", {"OpenImageIO/"}, "common/imaging/.*|cli/import/.*"};
    EXPECT_THAT(fence_findings(sources(), fence), IsEmpty());
}

TEST(House, SceneReadersStayInImport) {
    const Fence fence{"a scene reader", {"tiny_gltf", "tiny_obj_loader", "assimp/"}, "cli/import/.*"};
    EXPECT_THAT(fence_findings(sources(), fence), IsEmpty());
}

TEST(House, CoresReadNoClockAndNoRandomDevice) {
    const std::regex allowed("common/(net|service)/.*|cli/(bench/)?[^/]*|worker/slot_thread\\.cpp|" + shells);
    SourceTree cores;
    std::ranges::copy_if(sources(), std::back_inserter(cores),
                         [&](const SourceFile& file) { return !std::regex_match(file.path, allowed); });
    ASSERT_GT(cores.size(), 100u);
    EXPECT_THAT(pattern_findings(cores, R"(_clock::now|clock_gettime|gettimeofday|random_device)", "a core that reads"),
                IsEmpty());
}

TEST(House, CoresHaveNoThreads) {
    const Fence fence{"threading",
                      {"thread", "mutex", "condition_variable", "atomic", "future", "pthread.h"},
                      "common/(net|service)/.*|cli/[^/]*|cli/bench/daemon\\.cpp|worker/slot_thread\\.(h|cpp)|worker/"
                      "paced/scratch_maps\\.(h|cpp)|common/octree/"
                      "octree\\.cpp|common/imaging/render\\.cpp|"
                      "common/transport/clearance\\.cpp|" +
                          shells};
    EXPECT_THAT(fence_findings(sources(), fence), IsEmpty());
}

TEST(House, CounterBasedRandomNumbersComeFromTheMathRoom) {
    const Fence fence{"Random123", {"Random123/"}, "common/math/.*"};
    EXPECT_THAT(fence_findings(sources(), fence), IsEmpty());
}

TEST(House, FilesStayShort) { EXPECT_THAT(length_findings(repository(), file_lines_max), IsEmpty()); }

TEST(House, NothingIsLeftUnfinished) { EXPECT_THAT(unfinished_work_findings(repository()), IsEmpty()); }

TEST(House, NoFileNamesAPathOfOneMachine) { EXPECT_THAT(machine_path_findings(repository()), IsEmpty()); }

TEST(House, LinksOfThePagesLeadToFiles) { EXPECT_THAT(broken_link_findings(repository(), root), IsEmpty()); }

TEST(House, TheArchitecturePageNamesEveryFolderOfSources) {
    EXPECT_THAT(unnamed_folder_findings(sources(), file_at("docs/architecture.md")), IsEmpty());
}

TEST(House, EveryFolderOfTestsIsBuilt) {
    EXPECT_THAT(unbuilt_test_findings(repository(), file_at("tests/CMakeLists.txt")), IsEmpty());
}

TEST(House, SetupNamesBoostWithItsVersion) {
    const SourceTree setup{file_at("deploy/setup")};
    EXPECT_THAT(pattern_findings(setup, R"(\blibboost(-[a-z-]+)?-dev\b|\blibboost-all\b)", "swaps Boost out silently:"),
                IsEmpty());
}

TEST(House, EntryScriptsAreExecutable) {
    namespace fs = std::filesystem;
    for (const char* script : {".ci/run", "deploy/setup", "deploy/build", "deploy/demo", "deploy/test"}) {
        ASSERT_TRUE(fs::exists(root / script)) << script;
        EXPECT_NE(fs::status(root / script).permissions() & fs::perms::owner_exec, fs::perms::none) << script;
    }
}

}  // namespace
}  // namespace lumenfarm::house
