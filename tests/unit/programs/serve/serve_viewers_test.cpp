/// What viewers get, good ones and bad ones.
#include "serve_fixture.h"

#include <equistream/send_times.h>

namespace equistream::test {
namespace {

std::int64_t due_at(const SendTimes& times, double time_s) {
    std::int64_t bytes = 0;
    for (const DueBytes& part : times.parts)
        if (part.time_s <= time_s)
            bytes = part.end;
    return bytes;
}

TEST_F(Serving, TwoViewersGetTheBytesOfTheFile) {
    for (const char* name : {"a.mkv", "a.mp4"}) {
        const std::string stream = record(name);
        Server server(arguments(name), place());
        Viewer first(server.port()), second(server.port());
        std::thread beside([&] { second.read(); });
        EXPECT_TRUE(first.read() == stream) << name << ": " << first.read().size() << " of " << stream.size();
        beside.join();
        EXPECT_TRUE(second.read() == stream) << name << ": " << second.read().size() << " of " << stream.size();
        first.leave();
        second.leave();
        EXPECT_TRUE(comes_true([&] { return server.lines_with("has all") == 2; })) << server.log();
        EXPECT_EQ(server.end_by(SIGTERM), 0);
    }
}

TEST_F(Serving, NoByteComesBeforeItIsDue) {
    const std::string stream = record("a.mkv");
    const SendTimes times = read_send_times(path("a.mkv"));
    ASSERT_GT(times.parts.back().time_s, 0.2);
    Server server(arguments("a.mkv"), place());
    Viewer viewer(server.port());
    EXPECT_TRUE(viewer.read() == stream);
    ASSERT_FALSE(viewer.arrivals().empty());
    for (const Arrival& arrival : viewer.arrivals())
        EXPECT_LE(arrival.bytes, due_at(times, arrival.elapsed_s)) << "at " << arrival.elapsed_s << " s";
    EXPECT_GE(viewer.arrivals().back().elapsed_s, times.parts.back().time_s);
}

TEST_F(Serving, ALoopBeginsAgainNoEarlierThanItEnds) {
    const std::string stream = record("a.mkv");
    const SendTimes times = read_send_times(path("a.mkv"));
    EXPECT_NEAR(times.duration_s, 0.4, 1e-3);
    Server server(arguments("a.mkv", {"--loop"}), place());
    Viewer viewer(server.port());
    EXPECT_TRUE(viewer.read(2 * stream.size() + 1000) == stream + stream + stream.substr(0, 1000));
    for (const Arrival& arrival : viewer.arrivals()) {
        if (arrival.bytes > std::int64_t(stream.size())) {
            EXPECT_GE(arrival.elapsed_s, times.duration_s) << arrival.bytes;
        }
        if (arrival.bytes > std::int64_t(2 * stream.size())) {
            EXPECT_GE(arrival.elapsed_s, 2 * times.duration_s) << arrival.bytes;
        }
    }
    EXPECT_EQ(server.end_by(SIGTERM), 0) << "while it is sending";
    EXPECT_LT(viewer.read().size(), 100 * stream.size());
}

TEST_F(Serving, ViewersMayLeaveAndReturn) {
    const std::string stream = record("a.mkv");
    Server server(arguments("a.mkv"), place());
    for (int visit = 0; visit < 3; ++visit) {
        Viewer leaving(server.port()), breaking(server.port());
        EXPECT_EQ(leaving.read(100).size(), 100u);
        EXPECT_EQ(breaking.read(100).size(), 100u);
        leaving.leave();
        breaking.break_off();
    }
    EXPECT_TRUE(comes_true([&] { return server.lines_with(" left") == 6; })) << server.log();
    Viewer returned(server.port());
    EXPECT_TRUE(returned.read() == stream);
    EXPECT_EQ(server.end_by(SIGTERM), 0);
}

/// What it is sent a server that reads all it can takes by the gigabyte; systems on the way keep some megabytes.
TEST_F(Serving, GarbageIsReadSlowlyAndDropped) {
    constexpr std::int64_t max_accepted = 24 << 20;
    constexpr double sending_s = 1;
    const std::string stream = record("a.mkv");
    Server server(arguments("a.mkv", {"--loop"}), place());
    Viewer rude(server.port());
    const std::string garbage(1 << 16, '\xa5');
    std::int64_t accepted = 0;
    for (const auto start = Clock::now(); seconds_since(start) < sending_s;) {
        const ssize_t count = send(rude.handle(), garbage.data(), garbage.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
        ASSERT_TRUE(count > 0 || errno == EAGAIN) << errno;
        accepted += std::max<ssize_t>(count, 0);
        if (count < 0)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        ASSERT_LT(accepted, max_accepted);
    }
    EXPECT_GT(accepted, 0);
    EXPECT_TRUE(rude.read(stream.size()) == stream);
    Viewer polite(server.port());
    EXPECT_TRUE(polite.read(stream.size()) == stream);
    EXPECT_EQ(server.end_by(SIGTERM), 0);
}

TEST_F(Serving, WhoeverDoesNotReadIsDroppedAndOthersGoOn) {
    const std::string stream = record_large("a.mkv");
    Server server(arguments("a.mkv", {"--patience", "2"}), place());
    Viewer idle(server.port(), 4096);
    Viewer reading(server.port());
    EXPECT_TRUE(reading.read() == stream) << reading.read().size();
    EXPECT_TRUE(comes_true([&] { return server.lines_with("did not read for 2 s") == 1; })) << server.log();
    EXPECT_LT(idle.read().size(), stream.size());
    EXPECT_EQ(server.end_by(SIGTERM), 0);
    EXPECT_NE(server.output().find("dropped 1;"), std::string::npos) << server.output();
}

TEST_F(Serving, WhoeverReadsButStaysBehindIsDropped) {
    const std::string stream = record_large("a.mkv");
    Server server(arguments("a.mkv", {"--patience", "0.5"}), place());
    Viewer slow(server.port(), 4096);
    EXPECT_TRUE(comes_true([&] {
        slow.read(slow.arrivals().empty() ? 100 : std::size_t(slow.arrivals().back().bytes) + 32768);
        return server.lines_with("stayed more than 0.5 s behind") == 1;
    })) << server.log();
    EXPECT_LT(slow.read().size(), stream.size());
    EXPECT_EQ(server.end_by(SIGTERM), 0);
    EXPECT_NE(server.output().find("dropped 1;"), std::string::npos) << server.output();
}

TEST_F(Serving, WhoeverStaysAfterTheEndIsSentAway) {
    const std::string stream = record("a.mkv");
    Server server(arguments("a.mkv", {"--patience", "0.2"}), place());
    Viewer staying(server.port());
    EXPECT_TRUE(staying.read() == stream);
    EXPECT_TRUE(comes_true([&] { return server.lines_with("did not hang up for 0.2 s after the end") == 1; }))
        << server.log();
}

TEST_F(Serving, MoreViewersThanTheLimitAreRefused) {
    const std::string stream = record("a.mkv");
    Server server(arguments("a.mkv", {"--viewers", "2", "--loop"}), place());
    Viewer first(server.port()), second(server.port());
    EXPECT_EQ(first.read(1).size(), 1u);
    EXPECT_EQ(second.read(1).size(), 1u);
    EXPECT_EQ(Viewer(server.port()).read().size(), 0u);
    EXPECT_EQ(server.lines_with("refused"), 1) << server.log();
    first.leave();
    EXPECT_TRUE(comes_true([&] { return server.lines_with(" left") == 1; })) << server.log();
    EXPECT_TRUE(Viewer(server.port()).read(stream.size()) == stream);
    EXPECT_EQ(server.end_by(SIGTERM), 0);
    EXPECT_NE(server.output().find("viewers served 3, refused 1,"), std::string::npos) << server.output();
}

}  // namespace
}  // namespace equistream::test
