/// Addresses that a server listens to, and those that it counts viewers by.
#include <programs/serve/server.h>

#include <equistream/error.h>

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
    for (const char* url : {"tcp://127.0.0.1:9000", "tcp://[::1]:9000", "tcp://[2001:db8::5]:65535"})
        EXPECT_EQ(url_of(parse_listen_address(url, "--listen")), url);
    EXPECT_THROW(parse_listen_address("tcp://[::1:9000", "--listen"), InputError);
}

}  // namespace
}  // namespace equistream::serve
