#include "common/net/connector.h"
#include "tests/net/loopback.h"

#include <sys/resource.h>

#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <vector>

namespace lumenfarm::net {
namespace {

using test::tcp;

Result<std::unique_ptr<Listener>> listen(boost::asio::io_context& io, const HostPort& where) {
    return Listener::open(io, where, [](tcp::socket) {});
}

TEST(Listener, BusyPortIsOneSentence) {
    boost::asio::io_context io;
    const auto first = listen(io, {"127.0.0.1", 0});
    ASSERT_TRUE(first.has_value());
    EXPECT_TRUE((*first)->on_loopback());
    const auto port = (*first)->local().port();
    EXPECT_NE(port, 0);
    const auto second = listen(io, {"127.0.0.1", port});
    ASSERT_TRUE(second.has_error());
    EXPECT_EQ(second.error().code, ErrorCode::failed);
    EXPECT_EQ(second.error().sentence,
              "cannot listen on 127.0.0.1:" + std::to_string(port) + ": the port is in use by another program");
}

TEST(Listener, AddressOfAnotherMachineIsOneSentence) {
    boost::asio::io_context io;
    const auto listener = listen(io, {"192.0.2.1", 0});
    ASSERT_TRUE(listener.has_error());
    EXPECT_NE(listener.error().sentence.find("192.0.2.1:0"), std::string::npos);
}

TEST(Listener, PortIsFreeAgainAfterwards) {
    boost::asio::io_context io;
    auto first = listen(io, {"127.0.0.1", 0});
    ASSERT_TRUE(first.has_value());
    const auto port = (*first)->local().port();
    first->reset();
    EXPECT_TRUE(listen(io, {"127.0.0.1", port}).has_value());
}

TEST(Listener, WantOfDescriptorsIsToldOnceAndLastsNoLongerThanItself) {
#if defined(__SANITIZE_ADDRESS__)
    GTEST_SKIP() << "UndefinedBehaviorSanitizer opens a pipe to look at a pointer, and takes its want for a finding";
#endif
    boost::asio::io_context io;
    int accepted = 0;
    std::vector<std::string> failures;
    const auto listener = Listener::open(
        io, {"127.0.0.1", 0}, [&](tcp::socket) { ++accepted; },
        [&](const std::string& why) { failures.push_back(why); });
    ASSERT_TRUE(listener.has_value());
    tcp::socket peer(io);
    peer.open(tcp::v4());
    rlimit before{};
    ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
    const rlimit none_left{static_cast<rlim_t>(peer.native_handle()) + 1, before.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none_left), 0);
    peer.connect((*listener)->local());
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    for (int retries = 0; (failures.empty() || retries < 3) && io.run_one_until(deadline) > 0;) ++retries;
    EXPECT_EQ(accepted, 0);
    EXPECT_EQ(failures.size(), 1u);
    ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
    while (accepted == 0 && io.run_one_until(deadline) > 0) {
    }
    EXPECT_EQ(accepted, 1);
}

std::optional<Result<tcp::socket>> try_connect(boost::asio::io_context& io, const HostPort& where, double seconds) {
    std::optional<Result<tcp::socket>> result;
    Connector connector(io, where, seconds, [&](auto done) { result.emplace(std::move(done)); });
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (!result && io.run_one_until(deadline) > 0) {
    }
    return result;
}

TEST(Connector, ReachesAListener) {
    boost::asio::io_context io;
    const auto listener = listen(io, {"127.0.0.1", 0});
    ASSERT_TRUE(listener.has_value());
    const auto socket = try_connect(io, {"127.0.0.1", (*listener)->local().port()}, 5);
    ASSERT_TRUE(socket && socket->has_value());
}

TEST(Connector, MasterThatIsNotThereIsOneSentence) {
    boost::asio::io_context io;
    std::uint16_t port = 0;
    {
        const auto listener = listen(io, {"127.0.0.1", 0});
        ASSERT_TRUE(listener.has_value());
        port = (*listener)->local().port();
    }
    const auto socket = try_connect(io, {"127.0.0.1", port}, 5);
    ASSERT_TRUE(socket && socket->has_error());
    EXPECT_EQ(socket->error().code, ErrorCode::failed);
    EXPECT_EQ(socket->error().sentence, "cannot connect to 127.0.0.1:" + std::to_string(port) + ": Connection refused");
}

TEST(Connector, DestroyedConnectorDoesNotCall) {
    boost::asio::io_context io;
    const auto listener = listen(io, {"127.0.0.1", 0});
    ASSERT_TRUE(listener.has_value());
    bool called = false;
    {
        Connector connector(io, {"127.0.0.1", (*listener)->local().port()}, 5, [&](auto) { called = true; });
    }
    io.poll();
    EXPECT_FALSE(called);
}

TEST(Reconnect, DelayIsJitteredAndBounded) {
    EXPECT_EQ(reconnect_delay_seconds(0, 0.0), limits::reconnect_seconds_min);
    EXPECT_EQ(reconnect_delay_seconds(1'000'000, 0.0), limits::reconnect_seconds_min);
    double last = 0;
    for (unsigned attempt = 0; attempt < 40; ++attempt) {
        const double most = reconnect_delay_seconds(attempt, 0.999'999);
        EXPECT_GE(most, last);
        EXPECT_LE(most, limits::reconnect_seconds_max);
        last = most;
    }
    EXPECT_LT(reconnect_delay_seconds(0, 0.999'999), 1.0);
    EXPECT_GT(last, 29.9);
}

}  // namespace
}  // namespace lumenfarm::net
