/// Who may have the stream by a browser, and how many may ask.
#include <programs/serve/counted_address.h>
#include <programs/serve/web_connections.h>

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace equistream::serve {
namespace {

TEST(WebNames, OfThisMachineAreThreeAndNoMore) {
    for (const char* own : {"localhost", "localhost:80", "127.0.0.1:8080", "[::1]", "[::1]:80"})
        EXPECT_TRUE(is_own_name(own)) << own;
    for (const char* other : {"", "localhost.evil.example:80", "127.0.0.1.evil.example", "[::2]:80", "[::1", "evil:80"})
        EXPECT_FALSE(is_own_name(other)) << other;
}

TEST(WebNames, OfThisMachineIsTheAddressThatIsListenedOn) {
    EXPECT_TRUE(is_own_name("127.0.0.2:80", "127.0.0.2"));
    EXPECT_TRUE(is_own_name("localhost:80", "127.0.0.2"));
    EXPECT_FALSE(is_own_name("127.0.0.2:80"));
    EXPECT_FALSE(is_own_name("127.0.0.2:80", "127.0.0.1"));
    EXPECT_FALSE(is_own_name("", ""));
}

TEST(WebNames, APageIsTheServersOwnByItsWholeOrigin) {
    EXPECT_TRUE(is_own_page("http://a:1", "a:1"));
    EXPECT_TRUE(is_own_page("https://a:1", "a:1"));
    for (const char* other : {"", "null", "a:1", "http://a:2", "http://a:1.evil.example", "ftp://a:1"})
        EXPECT_FALSE(is_own_page(other, "a:1")) << other;
}

TEST(WebNames, AKeyIsReadAsItWasSaid) {
    EXPECT_EQ(key_in("/stream?key=ab%20c&x=1"), "ab c");
    for (const char* plain : {"%zz", "%4", "%", "%-1", ""})
        EXPECT_EQ(key_in("/stream?key=" + std::string(plain)), plain);
    EXPECT_EQ(key_in("/stream"), "");
    EXPECT_TRUE(is_same_secret("abc", "abc"));
    EXPECT_FALSE(is_same_secret("abd", "abc"));
    EXPECT_FALSE(is_same_secret("ab", "abc"));
}

net::ip::address counted(const char* text) {
    return counted_address(net::ip::make_address(text));
}

TEST(WebAddress, OfIpv6ANetworkCountsAsOne) {
    EXPECT_EQ(counted("2001:db8:0:1::5"), counted("2001:db8:0:1:ffff:ffff:ffff:ffff"));
    EXPECT_NE(counted("2001:db8:0:1::5"), counted("2001:db8:0:2::5"));
    EXPECT_TRUE(counted("::1").is_loopback());
}

TEST(WebAddress, OfIpv4EachCountsWhicheverWayItComes) {
    EXPECT_NE(counted("192.0.2.1"), counted("192.0.2.2"));
    EXPECT_EQ(counted("::ffff:192.0.2.1"), counted("192.0.2.1"));
    EXPECT_NE(counted("::ffff:192.0.2.1"), counted("::ffff:192.0.2.2"));
}

TEST(WebCrowd, HasRoomForSixteenOfEachAddressAndSixtyFourInAll) {
    Crowd crowd;
    std::vector<Crowd::Place> places;
    const auto let_in = [&](const char* from, int count) {
        int in = 0;
        for (const auto address = net::ip::make_address(from); in < count && crowd.has_room_for(address); ++in)
            places.emplace_back(crowd, address);
        return in;
    };
    EXPECT_EQ(let_in("192.0.2.1", 20), 16);
    EXPECT_EQ(let_in("127.0.0.1", 20), 20);
    EXPECT_EQ(let_in("192.0.2.2", 20), 16);
    EXPECT_EQ(let_in("192.0.2.3", 20), 12) << "64 in all";
    EXPECT_EQ(let_in("127.0.0.1", 1), 0);
    places.front().leave();
    places.front().leave();  // counts once
    EXPECT_EQ(let_in("192.0.2.1", 9), 1);
}

}  // namespace
}  // namespace equistream::serve
