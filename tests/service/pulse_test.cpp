#include "common/service/pulse.h"

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <future>
#include <thread>
#include <vector>

namespace lumenfarm {
namespace {

/// A thread whose turn to answer comes when the test says so.
struct Asked {
    std::vector<ServingThread::Answer> answers;

    ServingThread thread(const std::string& name, double busy_seconds_max = 0) {
        return {name, [this](ServingThread::Answer answer) { answers.push_back(std::move(answer)); }, busy_seconds_max};
    }
    void answer() {
        for (const auto& each : std::exchange(answers, {})) each();
    }
};

TEST(Pulse, IsThereWhileEveryThreadAnswersAndNamesTheOneThatDoesNot) {
    Asked loop, disk;
    Pulse pulse({loop.thread("loop"), disk.thread("disk")});
    EXPECT_FALSE(pulse.silent(0)) << "nobody was asked before";
    loop.answer();
    disk.answer();
    EXPECT_FALSE(pulse.silent(1));
    loop.answer();
    EXPECT_EQ(pulse.silent(2), "disk");
    EXPECT_EQ(pulse.silent(3), "disk");
    EXPECT_TRUE(loop.answers.empty()) << "asked again only when all have answered";
    disk.answer();
    EXPECT_FALSE(pulse.silent(4));
    EXPECT_EQ(loop.answers.size(), 1u);
    EXPECT_EQ(disk.answers.size(), 1u);
}

TEST(Pulse, AThreadThatWasNotAskedForItsAnswerTwiceIsAskedOnce) {
    Asked disk;
    Pulse pulse({disk.thread("disk")});
    pulse.silent(0);
    pulse.silent(1);
    pulse.silent(2);
    EXPECT_EQ(disk.answers.size(), 1u);
}

/// A real thread that computes, or hangs, when it has answered once.
class Worked {
public:
    explicit Worked(bool computes)
        : thread_([this, computes] {
              asked_.get_future().get()();
              answered_.set_value();
              if (!computes) return release_.get_future().wait();
              while (!released_) ++rounds_;
          }) {
        ask_ = [this](ServingThread::Answer answer) {
            if (!std::exchange(asked_once_, true)) asked_.set_value(std::move(answer));
        };
    }
    ~Worked() {
        released_ = true;
        release_.set_value();
        thread_.join();
    }
    ServingThread serving(double busy_seconds_max) const { return {"it", ask_, busy_seconds_max}; }
    void wait_for_its_answer() { answered_.get_future().wait(); }
    void wait_for_progress() const {
        const auto before = rounds_.load();
        while (rounds_ < before + 1'000'000) std::this_thread::yield();
    }

private:
    std::promise<ServingThread::Answer> asked_;
    std::promise<void> answered_, release_;
    std::atomic<bool> released_ = false;
    std::atomic<std::uint64_t> rounds_ = 0;
    bool asked_once_ = false;
    std::function<void(ServingThread::Answer)> ask_;
    std::thread thread_;
};

TEST(Pulse, AThreadThatComputesIsAliveForSoLong) {
    Worked busy(true);
    Pulse pulse({busy.serving(100)});
    EXPECT_FALSE(pulse.silent(0));
    busy.wait_for_its_answer();
    EXPECT_FALSE(pulse.silent(1)) << "asked a second time, and busy from now on";
    busy.wait_for_progress();
    EXPECT_FALSE(pulse.silent(50));
    busy.wait_for_progress();
    EXPECT_FALSE(pulse.silent(101));
    busy.wait_for_progress();
    EXPECT_EQ(pulse.silent(102), "it") << "that is no work any more";
}

TEST(Pulse, AThreadThatComputesIsNoExcuseForALoop) {
    Worked busy(true);
    Pulse pulse({busy.serving(0)});
    pulse.silent(0);
    busy.wait_for_its_answer();
    EXPECT_FALSE(pulse.silent(1));
    busy.wait_for_progress();
    EXPECT_EQ(pulse.silent(2), "it");
}

TEST(Pulse, AThreadThatHangsIsSilent) {
    Worked hanging(false);
    Pulse pulse({hanging.serving(100)});
    EXPECT_FALSE(pulse.silent(0));
    hanging.wait_for_its_answer();
    EXPECT_FALSE(pulse.silent(1));
    // what it still did on its way to the hanging call counts once
    pulse.silent(2);
    std::optional<std::string> silent;
    for (double now_s = 3; now_s < 90 && !silent; ++now_s) silent = pulse.silent(now_s);
    EXPECT_EQ(silent, "it");
}

}  // namespace
}  // namespace lumenfarm
