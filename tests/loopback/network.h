#pragma once

#include "tests/loopback/process.h"

#include <fcntl.h>
#include <sched.h>
#include <unistd.h>

#include <fstream>
#include <string>
#include <utility>
#include <vector>

/// A network of machines on one machine: namespaces, joined by pairs of virtual Ethernet devices. Linux only; needs
/// root or user namespaces, and `ip`, `nft`, `nsenter`, `unshare`.
namespace lumenfarm::testing {

/// While it lives this program and those that it starts are in a network of their own, with nothing but a loopback
/// device. One whose user is not root stays there, as root of its own namespace.
class OwnNetwork {
public:
    OwnNetwork() : outside_(::open("/proc/self/ns/net", O_RDONLY | O_CLOEXEC)) {
        const auto [user, group] = std::pair(::geteuid(), ::getegid());
        if (::unshare(CLONE_NEWNET) != 0) {
            if (::unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return;
            std::ofstream("/proc/self/setgroups") << "deny";
            std::ofstream("/proc/self/uid_map") << "0 " << user << " 1";
            std::ofstream("/proc/self/gid_map") << "0 " << group << " 1";
        }
        works_ = succeeds({"ip", "link", "set", "lo", "up"}) && succeeds({"nft", "list", "ruleset"});
    }
    OwnNetwork(const OwnNetwork&) = delete;
    OwnNetwork& operator=(const OwnNetwork&) = delete;
    ~OwnNetwork() {
        (void)::setns(outside_, CLONE_NEWNET);
        ::close(outside_);
    }

    bool works() const { return works_; }

private:
    int outside_;
    bool works_ = false;
};

/// One machine more. Its cable can be cut: then packets are lost in both directions, and nobody is told.
class Host {
public:
    explicit Host(int number)
        : number_(std::to_string(number)),
          device_("host" + number_),
          holder_({"/usr/bin/env", "unshare", "--net", "sh", "-c", "echo ready && exec sleep infinity"}) {
        inside_ = {"nsenter", "--net=/proc/" + std::to_string(holder_.id()) + "/ns/net"};
        works_ = holder_.read_until([&] { return holder_.out() == "ready\n"; }) &&
                 succeeds({"ip", "link", "add", device_, "type", "veth", "peer", "name", "cable", "netns",
                           std::to_string(holder_.id())}) &&
                 succeeds({"ip", "address", "add", outer_address() + "/30", "dev", device_}) &&
                 succeeds({"ip", "link", "set", device_, "up"}) &&
                 succeeds(inside({"ip", "address", "add", "10.77." + number_ + ".2/30", "dev", "cable"})) &&
                 succeeds(inside({"ip", "link", "set", "cable", "up"}));
    }

    bool works() const { return works_; }
    /// Of the machine with the test, as this host sees it.
    std::string outer_address() const { return "10.77." + number_ + ".1"; }
    /// The command, to be run on this host.
    std::vector<std::string> inside(const std::vector<std::string>& command) const {
        auto all = inside_;
        all.insert(all.end(), command.begin(), command.end());
        return all;
    }

    bool cut() const { return drop(device_, {}) && drop("cable", inside_); }
    bool mend() const { return undrop(device_, {}) && undrop("cable", inside_); }

private:
    /// What comes in by the device is lost.
    static bool drop(const std::string& device, std::vector<std::string> under) {
        const std::string table = "inet cut_" + device;
        under.insert(under.end(), {"nft", "add table " + table + "; add chain " + table +
                                              " in { type filter hook input priority 0; }; add rule " + table +
                                              " in iifname " + device + " drop"});
        return succeeds(std::move(under));
    }
    static bool undrop(const std::string& device, std::vector<std::string> under) {
        under.insert(under.end(), {"nft", "delete table inet cut_" + device});
        return succeeds(std::move(under));
    }

    std::string number_;
    std::string device_;
    Process holder_;
    std::vector<std::string> inside_;
    bool works_ = false;
};

}  // namespace lumenfarm::testing
