#include "common/net/address.h"

#include <boost/asio/ip/address.hpp>

#include <gtest/gtest.h>

namespace lumenfarm::net {
namespace {

TEST(HostPort, ReadsWhatPeopleWrite) {
    EXPECT_EQ(*HostPort::parse("localhost:7420"), (HostPort{"localhost", 7420}));
    EXPECT_EQ(*HostPort::parse("192.168.1.4:0"), (HostPort{"192.168.1.4", 0}));
    EXPECT_EQ(*HostPort::parse("[::1]:65535"), (HostPort{"::1", 65535}));
    EXPECT_EQ(HostPort::parse("[fe80::2]:80")->text(), "[fe80::2]:80");
}

TEST(HostPort, RefusesTheRestWithTheReason) {
    for (const char* text : {"", "host", ":80", "host:", "host:port", "host:65536", "host:-1", "host:80x", "::1:80",
                             "ho st:80", "[]:80", "http://host:80", "host: 80"}) {
        const auto parsed = HostPort::parse(text);
        ASSERT_TRUE(parsed.has_error()) << text;
        EXPECT_EQ(parsed.error().code, ErrorCode::bad_input);
        EXPECT_NE(parsed.error().sentence.find("'" + std::string(text) + "'"), std::string::npos);
    }
    EXPECT_TRUE(HostPort::parse(std::string(300, 'a') + ":80").has_error());
}

TEST(Loopback, IsKnownInAllItsForms) {
    const auto loopback = [](const char* text) { return is_loopback(boost::asio::ip::make_address(text)); };
    EXPECT_TRUE(loopback("127.0.0.1"));
    EXPECT_TRUE(loopback("127.9.9.9"));
    EXPECT_TRUE(loopback("::1"));
    EXPECT_TRUE(loopback("::ffff:127.0.0.1"));
    EXPECT_FALSE(loopback("0.0.0.0"));
    EXPECT_FALSE(loopback("::"));
    EXPECT_FALSE(loopback("192.168.1.1"));
    EXPECT_FALSE(loopback("::ffff:10.0.0.1"));
}

}  // namespace
}  // namespace lumenfarm::net
