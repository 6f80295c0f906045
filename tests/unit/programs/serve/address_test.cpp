/// Addresses that a server listens to, those that it counts viewers by, and how many lines they may fill.
#include <programs/serve/server.h>

#include <gtest/gtest.h>

namespace equistream::serve {
namespace {

asio::ip::address counted(const char* text) {
    return counted_address(asio::ip::make_address(text));
}

TEST(ServerAddress, OfIpv6ANetworkCountsAsOne) {
    EXPECT_EQ(counted("2001:db8:0:1::5"), counted("2001:db8:0:1:ffff:ffff:ffff:ffff"));
    EXPECT_NE(counted("2001:db8:0:1::5"), counted("2001:db8:0:2::5"));
}

TEST(ServerAddress, OfIpv4EachCountsWhicheverWayItComes) {
    EXPECT_NE(counted("192.0.2.1"), counted("192.0.2.2"));
    EXPECT_EQ(counted("::ffff:192.0.2.1"), counted("192.0.2.1"));
    EXPECT_NE(counted("::ffff:192.0.2.1"), counted("::ffff:192.0.2.2"));
}

TEST(ServerAddress, IsReadAsItIsWritten) {
    for (const char* url : {"tcp://127.0.0.1:9000", "tcp://[::1]:9000", "tcp://[2001:db8::5]:65535"}) {
        const auto endpoint = resolve(parse_server_address(url).value(), "--listen");
        EXPECT_EQ("tcp://" + peer_text(endpoint.address(), endpoint.port()), url);
    }
}

TEST(LogLines, AreSoManyAtOnceAndThenSoManyASecond) {
    LineLimit limit;
    const Clock::time_point start = Clock::now();
    const auto allowed = [&](double after_s, int asked) {
        int count = 0;
        for (int i = 0; i < asked; ++i)
            count += limit.allows(start +
                                  std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(after_s)));
        return count;
    };
    EXPECT_EQ(allowed(0, 30), 20);
    EXPECT_EQ(limit.take_left_out(), 10);
    EXPECT_EQ(allowed(0.4, 10), 0);
    EXPECT_EQ(allowed(0.6, 10), 1);
    EXPECT_EQ(allowed(100, 30), 20);
    EXPECT_EQ(limit.take_left_out(), 29);
    EXPECT_EQ(limit.take_left_out(), 0);
}

}  // namespace
}  // namespace equistream::serve
