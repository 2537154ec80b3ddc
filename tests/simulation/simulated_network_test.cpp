#include "common/support/limits.h"
#include "tests/simulation/world.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace lumenfarm::testing {
namespace {

/// Remembers what it heard, and when.
struct Listener : NetworkEnd {
    explicit Listener(World& world_) : world(world_) {}

    void on_open(ConnectionId connection) override { opened.push_back(connection); }
    void on_message(ConnectionId connection, wire::Message message, std::uint64_t) override {
        if (const auto* gone = std::get_if<wire::JobGone>(&message)) heard.emplace_back(connection, gone->job);
    }
    void on_close(ConnectionId, const std::optional<wire::Goodbye>& goodbye) override {
        closed_s = world.now_s();
        said = goodbye;
    }

    World& world;
    std::vector<ConnectionId> opened;
    std::vector<std::pair<ConnectionId, std::uint64_t>> heard;
    std::optional<double> closed_s;
    std::optional<wire::Goodbye> said;
};

constexpr HostId host = 1;

/// A master and a peer with an open session. Messages are numbered.
struct Session {
    explicit Session(std::uint64_t seed) : world(seed) {
        world.network.listen(&master);
        connection = world.network.connect(host, peer);
        pass(1);
        world.network.send(connection, Side::peer, wire::Hello(wire::Role::worker, "peer", 1));
        pass(1);
        world.network.send(connection, Side::master, wire::Welcome(1));
        pass(1);
    }
    void pass(double seconds) {
        bool over = false;
        world.clock.after(seconds, [&over] { over = true; });
        while (!over) world.clock.step();
    }
    void say(Side from, std::uint64_t number) { world.network.send(connection, from, wire::JobGone(number)); }

    World world;
    Listener master{world}, peer{world};
    ConnectionId connection = 0;
};

TEST(SimulatedNetwork, ConnectionKeepsTheOrderOfEachDirection) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        Session session(seed);
        session.world.network.set_latency(0.5, 3);
        for (std::uint64_t i = 1; i <= 50; ++i) session.say(Side::peer, i);
        session.pass(30);
        ASSERT_EQ(session.master.heard.size(), 50u);
        EXPECT_TRUE(std::is_sorted(session.master.heard.begin(), session.master.heard.end()));
        EXPECT_FALSE(session.master.closed_s || session.peer.closed_s);
    }
}

TEST(SimulatedNetwork, CutConnectionDeliversTheFirstPartAndBothEndsLearnOnTheirOwn) {
    std::size_t parts = 0, learned_late = 0;
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        Session session(seed);
        const double cut_s = session.world.now_s();
        for (std::uint64_t i = 1; i <= 10; ++i) session.say(Side::peer, i);
        session.world.network.cut(host);
        for (std::uint64_t i = 11; i <= 20; ++i) session.say(Side::peer, i);
        session.pass(2 * limits::dead_seconds);
        for (std::size_t i = 0; i < session.master.heard.size(); ++i)
            EXPECT_EQ(session.master.heard[i].second, i + 1) << "nothing is missing in between";
        EXPECT_LE(session.master.heard.size(), 10u);
        parts += session.master.heard.size() > 0 && session.master.heard.size() < 10;
        ASSERT_TRUE(session.master.closed_s && session.peer.closed_s);
        learned_late += std::abs(*session.master.closed_s - *session.peer.closed_s) > limits::heartbeat_seconds;
        EXPECT_LE(*session.master.closed_s, cut_s + limits::dead_seconds + 1);
        EXPECT_EQ(session.world.network.connections(), 0u);
    }
    EXPECT_GT(parts, 10u);
    EXPECT_GT(learned_late, 10u) << "half-open connections are what this is about";
}

TEST(SimulatedNetwork, ShortPartitionDelaysAndLosesNothing) {
    Session session(1);
    for (const Side side : {Side::master, Side::peer}) session.world.network.block(host, side, 8);
    session.say(Side::peer, 1);
    session.pass(7);
    EXPECT_TRUE(session.master.heard.empty());
    session.pass(5);
    EXPECT_EQ(session.master.heard.size(), 1u);
    EXPECT_FALSE(session.master.closed_s || session.peer.closed_s);
}

TEST(SimulatedNetwork, LongPartitionEndsTheConnectionAtBothEnds) {
    Session session(1);
    const double since_s = session.world.now_s();
    for (const Side side : {Side::master, Side::peer}) session.world.network.block(host, side, 60);
    session.pass(2 * limits::dead_seconds);
    ASSERT_TRUE(session.master.closed_s && session.peer.closed_s);
    EXPECT_GE(*session.master.closed_s, since_s + limits::dead_seconds - limits::heartbeat_seconds);
    EXPECT_TRUE(session.world.network.blocked(host, Side::master));
    Listener again{session.world};
    session.world.network.connect(host, again);
    session.pass(limits::connect_seconds + 1);
    EXPECT_TRUE(again.opened.empty() && again.closed_s) << "nobody gets through meanwhile";
}

TEST(SimulatedNetwork, OneDirectionBlockedIsNoticedByWhoHearsNothing) {
    Session session(1);
    session.world.network.block(host, Side::master, 60);
    session.pass(2 * limits::dead_seconds);
    ASSERT_TRUE(session.master.closed_s && session.peer.closed_s);
}

TEST(SimulatedNetwork, PowerCutOfAPeerIsLearnedFromSilenceAndAKilledProcessAtOnce) {
    Session silent(1), killed(1);
    const double since_s = silent.world.now_s();
    silent.world.network.vanish(silent.connection, Side::peer);
    killed.world.network.kill(killed.connection, Side::peer);
    // nobody sends: a heartbeat of the master's would be answered by the machine once it is up again
    silent.world.network.block(host, Side::peer, 60);
    silent.pass(2 * limits::dead_seconds);
    killed.pass(1);
    ASSERT_TRUE(silent.master.closed_s && killed.master.closed_s);
    EXPECT_GT(*silent.master.closed_s, since_s + limits::heartbeat_seconds);
    EXPECT_LT(*killed.master.closed_s, since_s + 1);
}

TEST(SimulatedNetwork, OldConnectionMayDeliverAfterItsSuccessor) {
    std::size_t overtaken = 0;
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        Session session(seed);
        session.world.network.set_latency(0.5, 0);
        session.say(Side::peer, 1);
        session.world.network.close(session.connection, Side::peer, wire::Goodbye());
        Listener again{session.world};
        const ConnectionId next = session.world.network.connect(host, again);
        while (again.opened.empty()) session.pass(0.001);
        session.world.network.send(next, Side::peer, wire::JobGone(1));
        session.pass(2);
        ASSERT_EQ(session.master.heard.size(), 2u) << "it is offered twice, and comes twice";
        overtaken += session.master.heard.front().first == next;
    }
    EXPECT_GT(overtaken, 0u);
}

TEST(SimulatedNetwork, GoodbyeComesAfterAllThatWasSaid) {
    Session session(1);
    session.say(Side::master, 7);
    session.world.network.close(session.connection, Side::master,
                                wire::Goodbye(wire::GoodbyeReason::shutting_down, "bye"));
    session.pass(1);
    EXPECT_EQ(session.peer.heard.size(), 1u);
    ASSERT_TRUE(session.peer.said);
    EXPECT_EQ(session.peer.said->text, "bye");
    EXPECT_FALSE(session.master.closed_s) << "who leaves hears nothing more";
}

TEST(SimulatedNetwork, NobodyIsLetInWhileTheMasterIsGone) {
    World world(1);
    Listener peer{world};
    world.network.connect(host, peer);
    while (!peer.closed_s) world.clock.step();
    EXPECT_LT(*peer.closed_s, 1);
    EXPECT_EQ(world.network.connections(), 0u);
}

}  // namespace
}  // namespace lumenfarm::testing
