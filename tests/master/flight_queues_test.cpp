#include "master/flight_queues.h"

#include <gtest/gtest.h>

#include <memory>

namespace lumenfarm {
namespace {

FlightQueues::Flights flights(std::uint32_t first, std::uint32_t count) {
    FlightQueues::Flights flights(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        flights[i].particle = first + i;
        flights[i].energy = 10;
    }
    return flights;
}

TEST(FlightQueues, NumberWhatIsFiledInEachSubspace) {
    FlightQueues queues(2);
    EXPECT_EQ(queues.file(1, flights(0, 5)).first, 0u);
    EXPECT_EQ(queues.file(1, flights(5, 3)).first, 5u);
    EXPECT_EQ(queues.file(0, flights(8, 1)).first, 0u);
    EXPECT_EQ(queues.filed(0), 1u);
    EXPECT_EQ(queues.filed(1), 8u);
    EXPECT_EQ(queues.energy(), 90);
    const auto across = queues.at(1, 3, 4);
    ASSERT_EQ(across.size(), 4u);
    for (std::uint32_t i = 0; i < 4; ++i) EXPECT_EQ(across[i].particle, 3 + i);
    EXPECT_EQ(queues.energy(1, 3, 4), 40);
}

TEST(FlightQueues, KeepWhatIsLeftUnderItsNumber) {
    FlightQueues queues(1);
    for (std::uint32_t i = 0; i < 4; ++i) queues.file(0, flights(10 * i, 10));
    queues.remove(0, 5, 20);
    EXPECT_EQ(queues.energy(), 200);
    EXPECT_EQ(queues.at(0, 0, 5).back().particle, 4u);
    EXPECT_EQ(queues.at(0, 25, 15).front().particle, 25u);
    queues.remove(0, 0, 5);
    queues.remove(0, 25, 15);
    EXPECT_EQ(queues.energy(), 0);
    EXPECT_EQ(queues.filed(0), 40u);
    EXPECT_EQ(queues.file(0, flights(40, 1)).first, 40u);
}

TEST(FlightQueues, AreCopiedByAddingWhatWasFiled) {
    FlightQueues first(1), second(1);
    second.add(first.file(0, flights(0, 7)));
    second.add(first.file(0, flights(7, 2)));
    EXPECT_EQ(second.filed(0), first.filed(0));
    EXPECT_EQ(second.at(0, 6, 3), first.at(0, 6, 3));
    second.skip_to(0, 20);
    EXPECT_EQ(second.file(0, flights(0, 1)).first, 20u);
}

TEST(FlightQueues, LentFlightsHaveAnyNumbers) {
    FlightQueues queues(1);
    queues.lend({0, 500, std::make_shared<const FlightQueues::Flights>(flights(500, 20))});
    queues.lend({0, 100, std::make_shared<const FlightQueues::Flights>(flights(100, 10))});
    EXPECT_EQ(queues.at(0, 505, 2).front().particle, 505u);
    EXPECT_EQ(queues.at(0, 100, 10).back().particle, 109u);
    EXPECT_FALSE(queues.may_lend(0, 95, 6));
    EXPECT_FALSE(queues.may_lend(0, 519, 1));
    EXPECT_TRUE(queues.may_lend(0, 110, 390));
    queues.remove(0, 100, 4);
    EXPECT_FALSE(queues.may_lend(0, 100, 4)) << "the others of its lease are here";
    queues.remove(0, 104, 6);
    EXPECT_TRUE(queues.may_lend(0, 100, 4));
    EXPECT_EQ(queues.energy(), 200);
}

}  // namespace
}  // namespace lumenfarm
