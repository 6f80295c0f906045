/// A server that does not answer, or says nothing, is given up in time, and the reason is told.
#include <client/receive/server_connection.h>
#include <tests/unit/silent_server.h>

#include <equistream/error.h>

#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <thread>

namespace equistream::test {
namespace {

constexpr Patience impatient{.connect_s = 0.3, .first_bytes_s = 0.4, .silence_s = 0.2};

/// What the WorkError says that `work` must end with, well before anybody would call it hanging.
std::string failure_of(const std::function<void()>& work) {
    const auto start = Clock::now();
    try {
        work();
    } catch (const WorkError& error) {
        EXPECT_LT(seconds_since(start), 5);
        return error.what();
    }
    ADD_FAILURE() << "no WorkError was thrown";
    return {};
}

TEST(ServerConnections, AServerThatDoesNotAnswerIsGivenUp) {
    SilentServer server(0);
    server.fill_up(0);
    PoseSender poses;
    EXPECT_EQ(failure_of([&] { ServerConnection(server.address(), poses, {}, impatient); }),
              server.address() + ": the server did not answer for 0.3 s");
}

TEST(ServerConnections, AServerThatSaysNothingIsGivenUp) {
    SilentServer server;
    PoseSender poses;
    ServerConnection connection(server.address(), poses, {}, impatient);
    std::array<std::uint8_t, 16> bytes{};
    EXPECT_EQ(failure_of([&] { connection.read(bytes); }), "the server sent nothing for 0.4 s");
    EXPECT_EQ(connection.read(bytes), 0u) << "it stays so";
}

TEST(ServerConnections, AServerThatFallsSilentIsGivenUp) {
    SilentServer server;
    PoseSender poses;
    ServerConnection connection(server.address(), poses, {}, impatient);
    server.send("all");
    std::array<std::uint8_t, 16> bytes{};
    EXPECT_EQ(connection.read(bytes), 3u);
    EXPECT_EQ(failure_of([&] { connection.read(bytes); }), "the server sent nothing for 0.2 s");
}

TEST(ServerConnections, WhoeverReadsSeldomDoesNotCallTheServerSilent) {
    SilentServer server;
    PoseSender poses;
    ServerConnection connection(server.address(), poses, {}, impatient);
    server.send("all");
    std::this_thread::sleep_for(std::chrono::milliseconds(600));
    std::array<std::uint8_t, 2> bytes{};
    EXPECT_EQ(connection.read(bytes), 2u);
    std::this_thread::sleep_for(std::chrono::milliseconds(600));
    EXPECT_EQ(connection.read(bytes), 1u);
}

TEST(ServerConnections, AServerThatIsNeverSilentIsGivenUpWhereNoFrameComesInTime) {
    SilentServer server;
    std::thread sending([&] { server.trickle(std::string(200, '\xec'), std::chrono::milliseconds(20)); });
    PoseSender poses;
    FeedOptions options;
    options.first_frame_limit_s = 0.5;
    const std::string expected = server.address() + ": no frame came within 0.5 s";
    options.poses = &poses;
    EXPECT_EQ(failure_of([&] { open_feed(server.address(), options)->next(); }), expected);
    sending.join();
    sending = std::thread([&] { server.trickle(std::string(200, '\xec'), std::chrono::milliseconds(20)); });
    options.poses = nullptr;  // libav connects
    EXPECT_EQ(failure_of([&] { open_feed(server.address(), options)->next(); }), expected);
    sending.join();
}

/// The thread sanitizer sees whether the socket is closed under whoever sends.
TEST(ServerConnections, HeadsMayBeSentWhileTheServerIsGivenUp) {
    SilentServer server;
    PoseSender poses;
    ServerConnection connection(server.address(), poses, {}, impatient);
    std::atomic<bool> is_over = false;
    std::thread sending([&] {
        for (double x_m = 0; !is_over; x_m += 1e-3) {
            poses.send({0, {{x_m, 0, 0}, {1, 0, 0, 0}}});
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
    });
    std::array<std::uint8_t, 16> bytes{};
    EXPECT_EQ(failure_of([&] { connection.read(bytes); }), "the server sent nothing for 0.4 s");
    is_over = true;
    sending.join();
    EXPECT_FALSE(poses.send({0, {{-1, 0, 0}, {1, 0, 0, 0}}}));
}

}  // namespace
}  // namespace equistream::test
