/// How many refused connections are held, and for how long.
#include <programs/serve/turned_away.h>

#include <asio/io_context.hpp>
#include <gtest/gtest.h>

#include <memory>

namespace equistream::serve {
namespace {

struct CountedWire : Wire {
    explicit CountedWire(int& open) : open_(open) { ++open_; }
    ~CountedWire() override { --open_; }
    void open(Opened) override {}
    void read_some(std::span<char>, Moved) override {}
    void write_some(std::span<const char>, Moved) override {}
    Unacknowledged unacknowledged() override { return {}; }
    void end_writing() override {}
    void close() override {}

private:
    int& open_;
};

struct Held {
    void add() { away.add(std::make_unique<CountedWire>(open)); }

    asio::io_context io;
    int open = 0;
    TurnedAway away{io.get_executor(), 3};
};

TEST(TurnedAwayConnections, AreClosedAfterTheirTime) {
    Held held;
    const auto start = TurnedAway::Clock::now();
    held.add();
    held.io.run_for(TurnedAway::held_for / 2);
    const auto second = TurnedAway::Clock::now();
    held.add();
    held.io.restart();
    while (held.open == 2)
        held.io.run_one();
    EXPECT_GE(TurnedAway::Clock::now() - start, TurnedAway::held_for);
    held.io.run();
    EXPECT_EQ(held.open, 0);
    EXPECT_GE(TurnedAway::Clock::now() - second, TurnedAway::held_for) << "each has its own time";
}

TEST(TurnedAwayConnections, BeyondTheLimitAreClosedAtOnce) {
    Held held;
    for (int i = 0; i < 5; ++i)
        held.add();
    EXPECT_EQ(held.open, 3);
    held.io.run();
    EXPECT_EQ(held.open, 0);
    held.add();
    EXPECT_EQ(held.open, 1) << "there is room again";
}

TEST(TurnedAwayConnections, LeaveNothingToDoOnceAllAreClosed) {
    Held held;
    held.add();
    held.away.clear();
    EXPECT_EQ(held.open, 0);
    held.io.poll();
    EXPECT_TRUE(held.io.stopped()) << "nothing is waited for";
}

}  // namespace
}  // namespace equistream::serve
