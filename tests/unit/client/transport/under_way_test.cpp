/// What is under way on lines that do not exist.
#include <client/transport/congestion.h>
#include <client/transport/under_way.h>

#include <gtest/gtest.h>

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>
#include <vector>

namespace equistream {
namespace {

TEST(UnderWay, ALineThatAcknowledgesInTimeIsNeverFull) {
    UnderWay under_way;
    std::int64_t written = 0;
    for (double time_s = 0; time_s < 5; time_s += 0.05) {
        // Of 100 kB a second what was written in the last 0.2 s is not acknowledged.
        under_way.see(time_s, written, {std::size_t(std::min<std::int64_t>(written, 20000)), 0.2});
        EXPECT_FALSE(under_way.is_too_much(time_s));
        written += 5000;
    }
    EXPECT_EQ(under_way.acknowledged(), written - 5000 - 20000);
}

TEST(UnderWay, WhatIsNotAcknowledgedForLongIsTooMuch) {
    UnderWay under_way;
    under_way.see(1, 0, {0, 0.04});
    under_way.see(1, 50000, {50000, 0.04});
    EXPECT_FALSE(under_way.is_too_much(1.3));
    EXPECT_TRUE(under_way.is_too_much(1.35)) << "three times 0.04 s and 0.2 s later";
    under_way.see(1.4, 50000, {4100, 0.04});
    EXPECT_TRUE(under_way.is_too_much(1.4));
    under_way.see(1.5, 50000, {4000, 0.04});
    EXPECT_FALSE(under_way.is_too_much(1.5)) << "so little may wait for a lost packet";
    EXPECT_TRUE(under_way.is_anything());
    under_way.see(1.6, 50000, {0, 0.04});
    EXPECT_FALSE(under_way.is_anything());
}

/// Of TLS the system counts bytes that nobody wrote.
TEST(UnderWay, MoreThanWasWrittenIsNoneAcknowledged) {
    UnderWay under_way;
    under_way.see(1, 1000, {1022, 0});
    EXPECT_EQ(under_way.acknowledged(), 0);
    under_way.see(1.1, 2000, {500, 0});
    EXPECT_EQ(under_way.acknowledged(), 1500);
    under_way.see(1.2, 2000, {900, 0});
    EXPECT_EQ(under_way.acknowledged(), 1500) << "nothing is taken back";
}

/// Two ends of TCP; the one that reads has room for little.
class UnreadBytes : public testing::Test {
protected:
    void SetUp() override {
        const int small = 4096;
        setsockopt(listening, SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socklen_t size = sizeof address;
        ASSERT_EQ(bind(listening, reinterpret_cast<sockaddr*>(&address), size), 0);
        ASSERT_EQ(listen(listening, 1), 0);
        ASSERT_EQ(getsockname(listening, reinterpret_cast<sockaddr*>(&address), &size), 0);
        ASSERT_EQ(connect(writes, reinterpret_cast<sockaddr*>(&address), size), 0);
        reads = accept(listening, nullptr, nullptr);
    }
    void TearDown() override {
        for (const int each : {reads, writes, listening})
            close(each);
    }

    int listening = socket(AF_INET, SOCK_STREAM, 0), writes = socket(AF_INET, SOCK_STREAM, 0), reads = -1;
};

/// Else whoever waits until less is under way would not see for long that the other end has gone.
TEST_F(UnreadBytes, AreUnderWayNoMoreOnceTheOtherEndHasBrokenOff) {
    const std::vector<char> bytes(100000);
    ASSERT_GT(send(writes, bytes.data(), bytes.size(), MSG_DONTWAIT), 20000);
    EXPECT_GT(unacknowledged(writes).bytes, 0u);
    close(std::exchange(reads, -1));
    for (int i = 0; i < 200 && unacknowledged(writes).bytes > 0; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_EQ(unacknowledged(writes).bytes, 0u);
}

TEST_F(UnreadBytes, AreUnacknowledgedAsTheSystemSays) {
    EXPECT_EQ(unacknowledged(writes).bytes, 0u);
    const std::vector<char> bytes(100000);
    const ssize_t written = send(writes, bytes.data(), bytes.size(), MSG_DONTWAIT);
    ASSERT_GT(written, 20000);
    const Unacknowledged waits = unacknowledged(writes);
    EXPECT_GT(waits.bytes, std::size_t(written) - 20000) << "the other end has room for less";
    EXPECT_LE(waits.bytes, std::size_t(written));
    EXPECT_GT(waits.soonest_s, 0);
    EXPECT_LT(waits.soonest_s, 1);
    std::vector<char> read(bytes.size());
    ASSERT_EQ(recv(reads, read.data(), std::size_t(written), MSG_WAITALL), written);
    for (int i = 0; i < 1000 && unacknowledged(writes).bytes > 0; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_EQ(unacknowledged(writes).bytes, 0u);
}

}  // namespace
}  // namespace equistream
