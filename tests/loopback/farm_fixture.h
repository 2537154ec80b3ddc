#pragma once

#include "common/net/blocking_client.h"
#include "common/scene/scene_file.h"
#include "tests/loopback/process.h"
#include "tests/scenes/scene_builder.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// A farm of real processes, started as a user would.
namespace lumenfarm::testing {

inline std::string scene_file(const Folder& folder) {
    const auto bytes = encode_scene(mixed_room());
    return folder.write("mixed.lfscene", {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

class Farm : public ::testing::Test {
protected:
    Farm() : scene_(scene_file(folder_)) {}
    /// A failed test shows the end of what its master and its workers have said.
    void TearDown() override {
        if (!HasFailure() || !master_) return;
        master_->send(SIGTERM);
        const auto status = master_->wait();
        ADD_FAILURE() << "the master ended with " << status.value_or(-1) << " and said last:\n"
                      << last_words(master_->err());
    }

    std::string path(const std::string& name) const { return (folder_ / name).string(); }

    std::unique_ptr<Process> start(const std::string& name, std::vector<std::string> arguments,
                                   std::vector<std::string> environment = {}) const {
        arguments.insert(arguments.begin(), program(name));
        environment.push_back("HOME=" + path(""));
        auto process = std::make_unique<Process>(std::move(arguments), std::move(environment));
        process->before_kill = [name](const std::string& said) {
            if (HasFailure()) ADD_FAILURE() << name << " said last:\n" << last_words(said);
        };
        return process;
    }

    /// At the address of an earlier one, if there was one. `under`: a command that starts it, found in the path.
    void launch_master(std::vector<std::string> options, std::vector<std::string> under = {},
                       std::vector<std::string> environment = {}) {
        const std::string listen = address_.empty() ? "127.0.0.1:0" : address_;
        if (!under.empty()) under.insert(under.begin(), "/usr/bin/env");
        under.push_back(program("lumenfarm-master"));
        under.insert(under.end(), {"--listen", listen, "--storage", path("store")});
        under.insert(under.end(), options.begin(), options.end());
        master_ = std::make_unique<Process>(std::move(under), std::move(environment));
    }
    /// False when it ended before.
    bool master_listens() { return listens(*master_, address_); }
    /// Reads where a daemon listens. False when it ended before.
    static bool listens(Process& daemon, std::string& address) {
        return daemon.read_until([&] {
            const auto at = daemon.err().find("listening on ");
            const auto end = at == std::string::npos ? at : daemon.err().find_first_of(",\n", at);
            if (end != std::string::npos) address = daemon.err().substr(at + 13, end - at - 13);
            return end != std::string::npos;
        });
    }
    void start_master(std::vector<std::string> options = {}) {
        launch_master(std::move(options));
        ASSERT_TRUE(master_listens()) << master_->err();
    }
    void kill_master() {
        master_->send(SIGKILL);
        EXPECT_EQ(master_->wait(), -SIGKILL) << master_->err();
    }

    /// A relay of the master, or of another relay.
    struct Relay {
        std::unique_ptr<Process> process;
        std::string address;
    };
    Relay start_relay(const std::string& name, std::vector<std::string> options = {}, const std::string& listen = {},
                      const std::string& upstream = {}) const {
        std::vector<std::string> all{"--upstream", upstream.empty() ? address_ : upstream,
                                     "--listen",   listen.empty() ? "127.0.0.1:0" : listen,
                                     "--storage",  path("relay-" + name),
                                     "--name",     name};
        all.insert(all.end(), options.begin(), options.end());
        Relay relay{start("lumenfarm-master", std::move(all)), {}};
        EXPECT_TRUE(listens(*relay.process, relay.address)) << relay.process->err();
        return relay;
    }

    /// `master`: its address; empty: of the farm's.
    std::unique_ptr<Process> start_worker(const std::string& name, const std::vector<std::string>& options = {},
                                          const std::string& master = {}) const {
        // at normal priority, so that other work on this machine does not starve it
        std::vector<std::string> all{"--normal-priority",
                                     "--master",
                                     master.empty() ? address_ : master,
                                     "--threads",
                                     "1",
                                     "--name",
                                     name,
                                     "--cache",
                                     path("cache-" + name)};
        all.insert(all.end(), options.begin(), options.end());
        return start("lumenfarm-worker", std::move(all));
    }

    /// Runs `lumenfarm` to its end and gives what it printed.
    std::string lumenfarm(std::vector<std::string> arguments, int expected_status = 0) const {
        const auto process = start("lumenfarm", std::move(arguments));
        const auto status = process->wait();
        EXPECT_EQ(status, expected_status) << process->err();
        return process->out();
    }
    boost::json::object json(std::vector<std::string> arguments) const {
        boost::json::error_code error;
        auto value = boost::json::parse(lumenfarm(std::move(arguments)), error);
        EXPECT_FALSE(error) << error.message();
        return value.is_object() ? value.as_object() : boost::json::object();
    }

    static bool can_inject() { return succeeds({"strace", "-o", "/dev/null", "true"}); }

    Result<net::BlockingClient> connect() const {
        return net::BlockingClient::connect(*net::HostPort::parse(address_), "test");
    }
    /// Looks at the farm until `wanted` holds; false when the watchdog's time is over, or nobody listens any more.
    template <class Reply, class Request, class Wanted>
    bool look_until(const Request& request, Wanted wanted) const {
        Result<net::BlockingClient> client = connect();
        const auto deadline = Clock::now() + watchdog;
        while (client && Clock::now() < deadline) {
            if (master_) master_->read_now();
            const auto reply = client->ask_for<Reply>(request);
            if (reply && wanted(*reply)) return true;
            // on a machine that is busy an impatient master may have closed
            if (!reply || !client->idle(0.02)) client = connect();
        }
        return false;
    }
    bool until_job(std::uint64_t job, const std::function<bool(const wire::JobStatus&)>& wanted) const {
        return look_until<wire::StatusReply>(wire::StatusRequest(job), [&](const wire::StatusReply& reply) {
            return reply.jobs.size() == 1 && wanted(reply.jobs.front());
        });
    }
    bool until_worker(const std::string& name, const std::function<bool(const wire::WorkerStatus&)>& wanted) const {
        return look_until<wire::WorkersReply>(wire::WorkersRequest(), [&](const wire::WorkersReply& reply) {
            for (const auto& worker : reply.workers)
                if (worker.name == name && wanted(worker)) return true;
            return false;
        });
    }

    /// How often `reasons` of the group have come up since the master started.
    static std::uint64_t counted(const wire::StatusReply& farm, std::string_view group,
                                 std::initializer_list<std::string_view> reasons) {
        std::uint64_t sum = 0;
        for (const auto& each : farm.counts)
            if (each.group == group && std::find(reasons.begin(), reasons.end(), each.reason) != reasons.end())
                sum += each.count;
        return sum;
    }
    bool until_farm(const std::function<bool(const wire::StatusReply&)>& wanted) const {
        return look_until<wire::StatusReply>(wire::StatusRequest(std::nullopt), wanted);
    }

    Folder folder_;
    std::string scene_;
    std::string address_;
    std::unique_ptr<Process> master_;
};

}  // namespace lumenfarm::testing
