#include "common/net/blocking_client.h"

#include "common/net/connection.h"
#include "common/net/file_transfer.h"
#include "common/net/listener.h"
#include "common/scene/scene_file.h"
#include "tests/net/loopback.h"

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/post.hpp>

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <map>
#include <set>
#include <thread>

namespace lumenfarm::net {
namespace {

/// A master that answers by a script, on a thread of its own.
class ScriptedMaster : ConnectionHandler {
public:
    using Script = std::function<void(Connection&, const wire::Envelope&)>;

    explicit ScriptedMaster(Script script) : script_(std::move(script)) {
        auto opened = Listener::open(io_, {"127.0.0.1", 0}, [this](test::tcp::socket socket) {
            connections_.push_back(Connection::make(std::move(socket), Connection::stranger(), *this));
            connections_.back()->start();
        });
        EXPECT_TRUE(opened.has_value());
        listener_ = std::move(*opened);
        address_ = {"127.0.0.1", listener_->local().port()};
        thread_ = std::thread([this] { io_.run(); });
    }
    ~ScriptedMaster() override {
        boost::asio::post(io_, [this] {
            listener_.reset();
            for (auto& connection : connections_) connection->detach();
        });
        thread_.join();
    }
    const HostPort& address() const { return address_; }
    Result<BlockingClient> connect() const { return BlockingClient::connect(address_, "test"); }

    /// The usual answer to Hello; true when the message was one.
    static bool welcome(Connection& connection, const wire::Envelope& envelope) {
        const auto* hello = std::get_if<wire::Hello>(&envelope.message);
        if (!hello) return false;
        EXPECT_EQ(hello->role, wire::Role::submitter);
        connection.open_session(wire::from_submitter, {}, 5, 15);
        connection.send(wire::Welcome(1), envelope.request_id);
        return true;
    }

private:
    void on_message(Connection& connection, wire::Envelope envelope) override { script_(connection, envelope); }
    void on_close(Connection&, const Closed&) override {}

    boost::asio::io_context io_;
    Script script_;
    std::vector<std::shared_ptr<Connection>> connections_;
    std::unique_ptr<Listener> listener_;
    HostPort address_;
    std::thread thread_;
};

TEST(BlockingClient, AsksAndIsAnswered) {
    ScriptedMaster master([](Connection& connection, const wire::Envelope& envelope) {
        if (ScriptedMaster::welcome(connection, envelope)) return;
        if (std::holds_alternative<wire::ControlRequest>(envelope.message)) {
            connection.send(wire::ControlReply(1, wire::JobState::done), envelope.request_id + 1'000);
            connection.send(wire::ControlReply(7, wire::JobState::cancelled), envelope.request_id);
        }
    });
    auto client = master.connect();
    ASSERT_TRUE(client.has_value()) << client.error().sentence;
    const auto reply = client->ask_for<wire::ControlReply>(wire::ControlRequest(7, wire::JobAction::cancel));
    ASSERT_TRUE(reply.has_value()) << reply.error().sentence;
    EXPECT_EQ(reply->job, 7u) << "an answer to another request was taken";
}

TEST(BlockingClient, RefusalBecomesTheUsersError) {
    ScriptedMaster master([](Connection& connection, const wire::Envelope& envelope) {
        if (ScriptedMaster::welcome(connection, envelope)) return;
        const bool fetch = std::holds_alternative<wire::FetchRequest>(envelope.message);
        const auto reason = fetch ? wire::RefusalReason::not_ready : wire::RefusalReason::no_such_job;
        connection.send(wire::Refusal(reason, "there is no job 8"), envelope.request_id);
    });
    auto client = master.connect();
    ASSERT_TRUE(client.has_value());
    const auto cancel = client->ask(wire::ControlRequest(8, wire::JobAction::cancel));
    ASSERT_TRUE(cancel.has_error());
    EXPECT_EQ(cancel.error().code, ErrorCode::bad_input);
    EXPECT_EQ(cancel.error().sentence, "there is no job 8");
    EXPECT_EQ(client->ask(wire::FetchRequest(8)).error().code, ErrorCode::failed);
}

TEST(BlockingClient, AnotherAnswerThanAskedForIsAnError) {
    ScriptedMaster master([](Connection& connection, const wire::Envelope& envelope) {
        if (ScriptedMaster::welcome(connection, envelope)) return;
        connection.send(wire::WorkersReply(), envelope.request_id);
    });
    auto client = master.connect();
    ASSERT_TRUE(client.has_value());
    const auto reply = client->ask_for<wire::StatusReply>(wire::StatusRequest());
    ASSERT_TRUE(reply.has_error());
    EXPECT_NE(reply.error().sentence.find("WorkersReply"), std::string::npos);
}

TEST(BlockingClient, MasterThatDoesNotAnswerIsAnError) {
    ScriptedMaster master(
        [](Connection& connection, const wire::Envelope& envelope) { ScriptedMaster::welcome(connection, envelope); });
    auto client = master.connect();
    ASSERT_TRUE(client.has_value());
    EXPECT_EQ(client->ask(wire::WorkersRequest(), 0.05).error().sentence, "the master did not answer in time");
}

TEST(BlockingClient, MasterThatSaysGoodbyeIsQuoted) {
    ScriptedMaster master([](Connection& connection, const wire::Envelope&) {
        connection.finish(wire::Goodbye(wire::GoodbyeReason::farm_full, "4096 sessions are open"));
    });
    const auto client = master.connect();
    ASSERT_TRUE(client.has_error());
    EXPECT_EQ(client.error().sentence, "the master ended the session: 4096 sessions are open");
}

TEST(BlockingClient, ConnectionLostWhileAskingIsAnError) {
    ScriptedMaster master([](Connection& connection, const wire::Envelope& envelope) {
        if (!ScriptedMaster::welcome(connection, envelope)) connection.close();
    });
    auto client = master.connect();
    ASSERT_TRUE(client.has_value());
    EXPECT_EQ(client->ask(wire::WorkersRequest()).error().code, ErrorCode::failed);
    EXPECT_TRUE(client->ask(wire::WorkersRequest()).has_error()) << "and stays one";
}

TEST(BlockingClient, NobodyThereIsOneSentence) {
    HostPort gone;
    {
        ScriptedMaster master([](Connection&, const wire::Envelope&) {});
        gone = master.address();
    }
    const auto client = BlockingClient::connect(gone, "test");
    ASSERT_TRUE(client.has_error());
    EXPECT_EQ(client.error().sentence, "cannot connect to " + gone.text() + ": Connection refused");
}

/// Serves one file by its chunks, and takes one.
struct FileStore {
    std::vector<std::byte> bytes;
    std::vector<Digest> chunks = chunk_digests(bytes);
    Digest digest = sha256(bytes);
    std::map<std::uint32_t, std::vector<std::byte>> uploaded = {};
    bool damage = false;

    std::vector<std::byte> chunk(std::uint32_t index) const {
        const auto begin = index * limits::chunk_bytes;
        const auto end = std::min(bytes.size(), begin + limits::chunk_bytes);
        std::vector<std::byte> copy(bytes.begin() + static_cast<std::ptrdiff_t>(begin),
                                    bytes.begin() + static_cast<std::ptrdiff_t>(end));
        if (damage && index == 1) copy[0] ^= std::byte{1};
        return copy;
    }
    void serve(Connection& connection, const wire::Envelope& envelope) {
        if (ScriptedMaster::welcome(connection, envelope)) return;
        if (std::holds_alternative<wire::ManifestRequest>(envelope.message))
            connection.send(wire::Manifest({digest, bytes.size(), chunks}), envelope.request_id);
        if (const auto* request = std::get_if<wire::ChunkRequest>(&envelope.message))
            connection.send(wire::Chunk(digest, request->index, chunk(request->index)), envelope.request_id);
        if (const auto* sent = std::get_if<wire::Chunk>(&envelope.message)) uploaded[sent->index] = sent->bytes;
        if (const auto* submit = std::get_if<wire::Submit>(&envelope.message)) answer(connection, *submit, envelope);
    }
    void answer(Connection& connection, const wire::Submit& submit, const wire::Envelope& envelope) const {
        std::vector<std::uint32_t> missing;
        for (std::uint32_t i = 1; i < submit.scene.chunks.size(); ++i)
            if (!uploaded.contains(i) || sha256(uploaded.at(i)) != submit.scene.chunks[i]) missing.push_back(i);
        connection.send(wire::SubmitReply(missing.empty() ? 33 : 0, missing), envelope.request_id);
    }
};

std::vector<std::byte> sample_bytes() {
    std::vector<std::byte> bytes(5 * limits::chunk_bytes / 2);
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::byte>(i * 2'654'435'761u >> 24);
    return bytes;
}

TEST(FileTransfer, FileComesWhole) {
    FileStore store{sample_bytes()};
    ScriptedMaster master([&](Connection& c, const wire::Envelope& e) { store.serve(c, e); });
    auto client = master.connect();
    ASSERT_TRUE(client.has_value());
    const auto fetched = fetch_file(*client, store.digest, limits::scene_bytes_max);
    ASSERT_TRUE(fetched.has_value()) << fetched.error().sentence;
    EXPECT_TRUE(*fetched == store.bytes);
}

TEST(FileTransfer, DamagedChunkIsNoticed) {
    FileStore store{sample_bytes()};
    store.damage = true;
    ScriptedMaster master([&](Connection& c, const wire::Envelope& e) { store.serve(c, e); });
    auto client = master.connect();
    ASSERT_TRUE(client.has_value());
    const auto fetched = fetch_file(*client, store.digest, limits::scene_bytes_max);
    ASSERT_TRUE(fetched.has_error());
    EXPECT_NE(fetched.error().sentence.find("chunk 1"), std::string::npos);
}

TEST(FileTransfer, FileOverTheCallersLimitIsNotFetched) {
    FileStore store{sample_bytes()};
    ScriptedMaster master([&](Connection& c, const wire::Envelope& e) { store.serve(c, e); });
    auto client = master.connect();
    ASSERT_TRUE(client.has_value());
    EXPECT_TRUE(fetch_file(*client, store.digest, 1'000).has_error());
}

TEST(FileTransfer, SubmitUploadsOnlyWhatIsMissing) {
    FileStore store{{}};
    ScriptedMaster master([&](Connection& c, const wire::Envelope& e) { store.serve(c, e); });
    const auto bytes = sample_bytes();
    std::optional<Result<std::uint64_t>> job;
    {
        auto client = master.connect();
        ASSERT_TRUE(client.has_value());
        job.emplace(submit_job(*client, 1, JobSpec(), bytes));
    }
    ASSERT_TRUE(job->has_value()) << job->error().sentence;
    EXPECT_EQ(**job, 33u);
    EXPECT_EQ(store.uploaded.size(), 2u) << "the master had chunk 0";
    EXPECT_EQ(store.uploaded.at(2).size(), limits::chunk_bytes / 2);
}

}  // namespace
}  // namespace lumenfarm::net
