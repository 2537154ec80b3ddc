#include "common/support/file.h"
#include "tests/loopback/farm_fixture.h"
#include "tests/solution/traced_run.h"

#include <gtest/gtest.h>
#include <boost/json.hpp>

#include <sstream>
#include <string>
#include <vector>

/// `bench farm` with real daemons.
namespace lumenfarm::testing {
namespace {

class FarmBench : public Farm {
protected:
    std::string text_of(const std::string& name) const {
        const auto bytes = read_file(path(name), 1 << 20);
        return bytes ? std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()) : std::string();
    }
    static std::vector<std::string> fields(const std::string& line) {
        std::vector<std::string> all;
        std::istringstream text(line);
        for (std::string field; std::getline(text, field, ',');) all.push_back(field);
        return all;
    }
    std::string digest(std::uint64_t particles) const {
        JobSpec spec;
        spec.particles = particles;
        return solution_digest(test::traced_run(mixed_room(), spec).solution).hex();
    }
};

TEST_F(FarmBench, CutsAreShownAsATableAndAsJson) {
    const std::vector<std::string> words{"bench",  "cuts", scene_,        "--subspaces", "2,4",
                                         "--cuts", "2",    "--particles", "5000"};
    const auto table = start("lumenfarm", words);
    ASSERT_EQ(table->wait(), 0) << table->err();
    for (const char* row : {"subspaces", " 4\n", "\nunweighted", "\nplanned", "\nby hits", "\nby time 1"})
        EXPECT_NE(table->out().find(row), std::string::npos) << table->out();
    std::vector<std::string> asked = words;
    asked.push_back("--json");
    const auto document = start("lumenfarm", asked);
    ASSERT_EQ(document->wait(), 0) << document->err();
    const auto columns = boost::json::parse(document->out()).as_array();
    ASSERT_EQ(columns.size(), 2u);
    EXPECT_EQ(columns[1].at("subspaces").as_int64(), 4);
    const auto& rows = columns[1].at("largest_over_mean").as_array();
    ASSERT_EQ(rows.size(), 4u);
    EXPECT_EQ(rows[3].at("cut").as_string(), "by time 1");
    for (const auto& row : rows) {
        EXPECT_GE(row.at("hits").as_double(), 1);
        EXPECT_LE(row.at("hits").as_double(), 4);
        EXPECT_GE(row.at("time").as_double(), 1);
    }
}

TEST_F(FarmBench, MeasuresEveryFarmAndEachResultIsThatOfRun) {
    // settings of somebody's own farm, which would end any daemon that read them
    const auto bench = start(
        "lumenfarm",
        {"bench", "farm", scene_, "--workers", "1,2", "--particles", "2000,5k", "--runs", "2", "-o", path("bench")},
        {"LUMENFARM_DEAD_SECONDS=x", "LUMENFARM_DRAIN_SECONDS=x", "LUMENFARM_FLUSH_SECONDS=x"});
    ASSERT_EQ(bench->wait(), 0) << bench->err();
    EXPECT_NE(bench->out().find("speed-up"), std::string::npos) << bench->out();
    std::istringstream lines(text_of("bench/bench.csv"));
    std::string line;
    std::getline(lines, line);
    EXPECT_EQ(fields(line).back(), "digest");
    std::size_t runs = 0;
    for (; std::getline(lines, line); ++runs) {
        const auto run = fields(line);
        ASSERT_EQ(run.size(), 19u) << line;
        EXPECT_EQ(run.back(), digest(std::stoull(run[2]))) << line;
        EXPECT_GT(std::stod(run[5]), 0) << "total time";
        EXPECT_GT(std::stod(run[6]), 0) << "tracing";
        EXPECT_GT(std::stod(run[8]), 0) << "the workers' processor time";
        EXPECT_GT(std::stoull(run[10]), 0u) << "bytes from workers";
        EXPECT_GT(std::stoull(run[11]), 0u) << "bytes to workers";
    }
    EXPECT_EQ(runs, 8u);
    for (const char* picture : {"speed-up-total.svg", "speed-up-tracing.svg", "efficiency.svg"})
        EXPECT_TRUE(text_of(std::string("bench/") + picture).starts_with("<svg")) << picture;
    EXPECT_NE(text_of("bench/bench.json").find("\"medians\""), std::string::npos);
}

TEST_F(FarmBench, CompressedResultsOfOneAtATimeAreFewerBytesAndTheSame) {
    std::vector<std::uint64_t> bytes;
    for (const bool compressed : {false, true}) {
        std::vector<std::string> arguments{"bench",     "farm",    scene_,   "--workers", "1",  "--particles", "20k",
                                           "--packing", "records", "--runs", "1",         "-o", path("bench")};
        if (compressed) arguments.insert(arguments.end(), {"--compress", "--results-in-flight", "1"});
        lumenfarm(arguments);
        std::istringstream lines(text_of("bench/bench.csv"));
        std::string line;
        std::getline(lines, line);
        ASSERT_TRUE(std::getline(lines, line));
        EXPECT_EQ(fields(line).back(), digest(20'000)) << line;
        bytes.push_back(std::stoull(fields(line)[10]));
    }
    EXPECT_LT(bytes[1], bytes[0]);
}

TEST_F(FarmBench, MeasuresFarmsWithRelays) {
    lumenfarm({"bench", "farm", scene_, "--workers", "1,3", "--relays", "2", "--particles", "5k", "--runs", "1", "-o",
               path("bench")});
    std::istringstream lines(text_of("bench/bench.csv"));
    std::string line;
    std::getline(lines, line);
    std::size_t runs = 0;
    for (; std::getline(lines, line); ++runs) {
        const auto run = fields(line);
        ASSERT_EQ(run.size(), 19u) << line;
        EXPECT_EQ(run.back(), digest(5'000)) << line;
        EXPECT_EQ(run[14], "2");
        EXPECT_GT(std::stod(run[15]), 0) << "the relays' processor time";
    }
    EXPECT_EQ(runs, 2u);
}

TEST_F(FarmBench, PacedWorkersGiveTheResultOfThoseThatTrace) {
    for (const char* packing : {"maps", "records"}) {
        const std::string shown =
            lumenfarm({"bench",  "farm",      scene_,   "--workers", "8",      "--relays", "2",
                       "--pace", "20k",       "--slow", "1",         "--jobs", "2",        "--particles",
                       "100k",   "--packing", packing,  "--runs",    "1",      "-o",       path("bench")});
        std::istringstream lines(text_of("bench/bench.csv"));
        std::string line;
        std::getline(lines, line);
        ASSERT_TRUE(std::getline(lines, line)) << shown;
        const auto run = fields(line);
        ASSERT_EQ(run.size(), 19u) << line;
        EXPECT_EQ(run.back(), digest(100'000)) << line;
        EXPECT_GE(std::stod(run[8]), 9.99) << "two jobs of 5 s, more of it with the slow one";
        EXPECT_NEAR(std::stod(run[17]), 10 / 7.1, 0.01) << "ideal";
        EXPECT_GE(std::stod(run[5]), std::stod(run[17])) << "nobody is quicker than its pace";
    }
}

TEST_F(FarmBench, AStoppedWorkersSetsGoToOthers) {
    lumenfarm({"bench", "farm", scene_, "--workers", "4", "--pace", "20k", "--stopped", "1", "--particles", "100k",
               "--set-seconds", "0.2", "--runs", "1", "-o", path("bench")});
    std::istringstream lines(text_of("bench/bench.csv"));
    std::string line;
    std::getline(lines, line);
    ASSERT_TRUE(std::getline(lines, line));
    const auto run = fields(line);
    EXPECT_EQ(run.back(), digest(100'000)) << line;
    EXPECT_NEAR(std::stod(run[17]), (5 - 0.625) / 3, 0.01) << "ideal: 5 s of work, of which the stopped one did 0.625";
    EXPECT_GE(std::stod(run[5]), std::stod(run[17])) << "more than with four";
}

TEST_F(FarmBench, PacedWorkersAndTrueOnesDoNotMix) {
    const std::vector<std::string> paced{"bench",    "paced",        scene_,    "--pace",     "1M",
                                         "--stored", path("stored"), "--cache", path("cache")};
    start_master();
    auto arguments = paced;
    arguments.insert(arguments.end(), {"--master", address_});
    const auto worker = start("lumenfarm", arguments);
    EXPECT_EQ(worker->wait(), 1);
    EXPECT_NE(worker->err().find("take part in measurements only"), std::string::npos) << worker->err();
}

TEST_F(FarmBench, AMasterOfPacedWorkersTakesNoTrueOnes) {
    start_master({"--paced-workers"});
    const auto worker = start_worker("one");
    EXPECT_EQ(worker->wait(), 1);
    EXPECT_NE(worker->err().find("take part in measurements only"), std::string::npos) << worker->err();
}

TEST_F(FarmBench, SweepsTheGranularityOfPacking) {
    const std::string shown = lumenfarm({"bench", "farm", scene_, "--workers", "1", "--particles", "2000", "--runs",
                                         "1", "--sweep", "hits-per-message", "-o", path("bench")});
    std::istringstream lines(text_of("bench/bench.csv"));
    std::vector<std::string> hits;
    for (std::string line; std::getline(lines, line);) hits.push_back(fields(line)[3]);
    EXPECT_EQ(hits, (std::vector<std::string>{"hits_per_message", "1", "100", "1000", "5000", "50000"})) << shown;
    EXPECT_TRUE(text_of("bench/hits-per-message.svg").starts_with("<svg"));
}

TEST_F(FarmBench, StatusTellsTheTraffic) {
    start_master();
    EXPECT_EQ(lumenfarm({"status", "--master", address_}).find("traffic"), std::string::npos);
    const auto worker = start_worker("one");
    lumenfarm({"submit", scene_, "--particles", "1000", "--master", address_, "--wait"});
    const auto status = json({"status", "--json", "--master", address_});
    EXPECT_GT(status.at("traffic").at("bytes_in").to_number<std::uint64_t>(), 0u);
    EXPECT_GT(status.at("traffic").at("messages_out").to_number<std::uint64_t>(), 0u);
    EXPECT_NE(lumenfarm({"status", "--master", address_}).find("messages from workers"), std::string::npos);
    const auto before = status.at("traffic").at("bytes_in").to_number<std::uint64_t>();
    worker->send(SIGTERM);
    EXPECT_EQ(worker->wait(), 0);
    const auto after = json({"status", "--json", "--master", address_});
    EXPECT_GE(after.at("traffic").at("bytes_in").to_number<std::uint64_t>(), before) << "of those that have ended, too";
}

}  // namespace
}  // namespace lumenfarm::testing
