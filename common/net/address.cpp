#include "common/net/address.h"

#include <boost/asio/ip/address.hpp>

#include <charconv>
#include <optional>
#include <string_view>

namespace lumenfarm::net {
namespace {

constexpr std::size_t host_bytes_max = 253;  // of a DNS name [RFC 1035]

std::optional<std::uint16_t> parse_port(std::string_view text) {
    std::uint16_t port = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
    if (error != std::errc() || end != text.data() + text.size() || text.empty()) return {};
    return port;
}

Error refuse(const std::string& text, const std::string& why) {
    return bad_input("'" + text.substr(0, host_bytes_max) + "' is not HOST:PORT: " + why);
}

}  // namespace

Result<HostPort> HostPort::parse(const std::string& text) {
    const auto colon = text.rfind(':');
    if (colon == std::string::npos) return refuse(text, "the port is missing");
    auto host = text.substr(0, colon);
    const bool bracketed = host.size() >= 2 && host.front() == '[' && host.back() == ']';
    if (bracketed) host = host.substr(1, host.size() - 2);
    if (host.empty()) return refuse(text, "the host is missing");
    if (!bracketed && host.find(':') != std::string::npos)
        return refuse(text, "write an IPv6 address as [ADDRESS]:PORT");
    const bool printable = host.find_first_of(" \t\r\n/[]") == std::string::npos;
    if (!printable || host.size() > host_bytes_max) return refuse(text, "the host is not a name or an address");
    const auto port = parse_port(std::string_view(text).substr(colon + 1));
    if (!port) return refuse(text, "the port is not a number from 0 to 65535");
    return HostPort{host, *port};
}

std::string HostPort::text() const {
    const auto shown = host.find(':') == std::string::npos ? host : "[" + host + "]";
    return shown + ":" + std::to_string(port);
}

bool is_loopback(const boost::asio::ip::address& address) {
    if (address.is_v6() && address.to_v6().is_v4_mapped())
        return boost::asio::ip::make_address_v4(boost::asio::ip::v4_mapped, address.to_v6()).is_loopback();
    return address.is_loopback();
}

std::string text_of(const boost::asio::ip::tcp::endpoint& endpoint) {
    return HostPort{endpoint.address().to_string(), endpoint.port()}.text();
}

}  // namespace lumenfarm::net
