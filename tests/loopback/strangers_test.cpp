#include "proto/messages.h"
#include "tests/loopback/farm_fixture.h"
#include "tests/solution/traced_run.h"

#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstdlib>
#include <span>
#include <vector>

/// Connections that do not behave, while the farm works. LUMENFARM_TEST_FAULTS: how many of each kind; a few by
/// default.
namespace lumenfarm::testing {
namespace {

/// A connection without any manners.
class Stranger {
public:
    explicit Stranger(const std::string& address) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
        const int little = 4'096;
        ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &little, sizeof little);
        sockaddr_in to{};
        to.sin_family = AF_INET;
        to.sin_port = htons(static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
        to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        EXPECT_EQ(::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
    }
    Stranger(Stranger&& other) noexcept : socket_(std::exchange(other.socket_, -1)) {}
    Stranger& operator=(Stranger&&) = delete;
    ~Stranger() {
        if (socket_ >= 0) ::close(socket_);
    }

    /// False when the other end takes no more.
    bool send(std::span<const std::byte> bytes, int flags = 0) const {
        return ::send(socket_, bytes.data(), bytes.size(), flags | MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
    }
    /// The end of the stream, in order.
    void end() const { ::shutdown(socket_, SHUT_WR); }

private:
    int socket_;
};

class FarmAmongStrangers : public Farm {
protected:
    static std::size_t of_each_kind() {
        const char* wanted = std::getenv("LUMENFARM_TEST_FAULTS");
        return wanted ? static_cast<std::size_t>(std::atoi(wanted)) : 2;
    }
    static std::vector<std::byte> hello() { return wire::encode(wire::Hello(wire::Role::submitter, "stranger", 1)); }
    std::vector<Stranger> come(std::size_t count) const {
        std::vector<Stranger> strangers;
        for (std::size_t i = 0; i < count; ++i) strangers.emplace_back(address_);
        return strangers;
    }
    bool until_counted(std::string_view group, std::initializer_list<std::string_view> reasons,
                       std::uint64_t times) const {
        return until_farm([&](const wire::StatusReply& farm) { return counted(farm, group, reasons) >= times; });
    }
    bool until_closed(std::initializer_list<std::string_view> reasons, std::uint64_t times) const {
        return until_counted("connections_closed", reasons, times);
    }
};

TEST_F(FarmAmongStrangers, EachIsClosedForItsReasonAndTheJobIsRight) {
    constexpr std::uint64_t particles = 6'000'000;
    const std::size_t count = of_each_kind();
    start_master({"--dead-seconds", "5"});
    const auto first = start_worker("first"), second = start_worker("second");
    ASSERT_EQ(lumenfarm({"submit", scene_, "--particles", std::to_string(particles), "--keep-hits", "500", "--master",
                         address_}),
              "1\n");

    std::vector<std::byte> half_hello = hello();
    half_hello.resize(limits::frame_header_bytes + 8);
    const auto mute = come(count);
    const auto half = come(count);
    for (const Stranger& stranger : half) EXPECT_TRUE(stranger.send(half_hello));
    {
        const auto cut_short = come(count);
        for (const Stranger& stranger : cut_short) EXPECT_TRUE(stranger.send(half_hello));
        for (const Stranger& stranger : cut_short) stranger.end();
        EXPECT_TRUE(until_closed({"half_frame"}, count));
    }
    const auto foreign = come(count);
    for (const Stranger& stranger : foreign)
        EXPECT_TRUE(stranger.send(std::vector<std::byte>(limits::frame_header_bytes, std::byte{'G'})));
    EXPECT_TRUE(until_counted("frames_refused", {"bad_magic"}, count));
    const auto silent = come(count);
    for (const Stranger& stranger : silent) EXPECT_TRUE(stranger.send(hello()));
    EXPECT_TRUE(until_closed({"silent"}, count));
    EXPECT_TRUE(until_closed({"no_hello"}, 2 * count)) << "those who say nothing, or half a message";

    for (std::size_t i = 0; i < count; ++i) {
        const Stranger deaf(address_);
        EXPECT_TRUE(deaf.send(hello()));
        std::vector<std::byte> questions;
        for (std::uint64_t asked = 1; asked <= 100; ++asked) {
            const auto question = wire::encode(wire::StatusRequest(std::nullopt), asked);
            questions.insert(questions.end(), question.begin(), question.end());
        }
        for (int times = 0; times < 200 && deaf.send(questions); ++times) {
        }
        EXPECT_TRUE(until_closed({"outbox_full", "write_stalled"}, i + 1));
    }

    ASSERT_TRUE(until_job(1, [](const wire::JobStatus& job) { return job.state == wire::JobState::done; }));
    const auto status = json({"status", "1", "--json", "--master", address_});
    JobSpec spec;
    spec.particles = particles;
    spec.keep_hits = 500;
    const Solution wanted = test::traced_run(mixed_room(), spec).solution;
    EXPECT_EQ(status.at("digest").as_string(), solution_digest(wanted).hex());
    EXPECT_EQ(status.at("hits").to_number<std::uint64_t>(), wanted.balance.hits);
    const auto counts = json({"status", "--json", "--master", address_}).at("counts").as_object();
    EXPECT_GE(counts.at("connections_closed").as_object().at("no_hello").to_number<std::uint64_t>(), 2 * count);
    EXPECT_NE(lumenfarm({"status", "--master", address_}).find("no_hello"), std::string::npos);
}

}  // namespace
}  // namespace lumenfarm::testing
