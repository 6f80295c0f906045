/// A viewer that reads slowly gets every block whole, and one that leaves is noticed. A renderer that does not do what
/// it should, played by a shell, is heard of in time and ended.
#include <programs/serve/children.h>
#include <programs/serve/viewer.h>

#include <equistream/elapsed.h>

#include <asio/buffer.hpp>
#include <asio/io_context.hpp>
#include <asio/read.hpp>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace equistream::serve {
namespace {

constexpr int blocks = 64;

/// Nothing at first but a time to ask again; from then on block after block, each of one letter.
class Letters : public Feed {
public:
    explicit Letters(double again_s) : again_s_(again_s) {}
    Portion next(std::span<char> block, double elapsed_s) override {
        if (std::exchange(is_first_, false))
            return {.again_s = again_s_};
        if (given_ == blocks)
            return {.ended = true};
        std::ranges::fill(block, letter(given_++));
        return {.bytes = block.size(), .due_s = elapsed_s};
    }
    static char letter(int block) { return char('a' + block % 26); }

private:
    double again_s_;
    bool is_first_ = true;
    int given_ = 0;
};

TEST(Viewers, GetWholeBlocksWhereATimeComesWhileOneIsSent) {
    constexpr std::size_t block_bytes = 1 << 16;
    asio::io_context io;
    asio::ip::tcp::acceptor acceptor(io, asio::ip::tcp::endpoint(asio::ip::address_v4::loopback(), 0));
    asio::ip::tcp::socket reader(io), served(io);
    reader.connect(acceptor.local_endpoint());
    acceptor.accept(served);
    served.set_option(asio::socket_base::send_buffer_size(4096));

    std::string how;
    const auto viewer =
        std::make_shared<Viewer>(io.get_executor(), tcp_wire(std::move(served)), std::make_unique<Letters>(0.2), 60);
    viewer->start([&](const std::string& as, const std::string&) { how = as; });
    viewer->wake();
    io.run_for(std::chrono::milliseconds(500));  // nobody reads: a block is on its way when the time comes

    std::string got(blocks * block_bytes + 1, '\0');
    std::thread reading([&] {
        asio::error_code end;
        got.resize(asio::read(reader, asio::buffer(got), end));
        reader.close();
    });
    io.run_for(std::chrono::seconds(60));
    reading.join();
    ASSERT_EQ(got.size(), blocks * block_bytes);
    for (int block = 0; block < blocks; ++block) {
        const auto text = std::string_view(got).substr(std::size_t(block) * block_bytes, block_bytes);
        EXPECT_EQ(text.find_first_not_of(Letters::letter(block)), std::string_view::npos) << block;
    }
    EXPECT_EQ(how, "has all");
}

TEST(Viewers, WhoHasSaidAllGetsAllTheSame) {
    asio::io_context io;
    asio::ip::tcp::acceptor acceptor(io, asio::ip::tcp::endpoint(asio::ip::address_v4::loopback(), 0));
    asio::ip::tcp::socket reader(io), served(io);
    reader.connect(acceptor.local_endpoint());
    acceptor.accept(served);
    reader.shutdown(asio::socket_base::shutdown_send);
    std::string how;
    const auto viewer =
        std::make_shared<Viewer>(io.get_executor(), tcp_wire(std::move(served)), std::make_unique<Letters>(0.1), 60);
    viewer->start([&](const std::string& as, const std::string&) { how = as; });
    std::string got((std::size_t(blocks) << 16) + 1, '\0');
    std::thread reading([&] {
        asio::error_code end;
        got.resize(asio::read(reader, asio::buffer(got), end));
    });
    io.run_for(std::chrono::seconds(60));
    reading.join();
    EXPECT_EQ(got.size(), std::size_t(blocks) << 16);
    EXPECT_EQ(how, "has all");
}

struct Silent : Feed {
    Portion next(std::span<char>, double) override { return {}; }
};

/// A scene's first sphere may take long, and a seat is a seat.
TEST(Viewers, WhoLeavesBeforeAnythingCameIsNoticed) {
    asio::io_context io;
    asio::ip::tcp::acceptor acceptor(io, asio::ip::tcp::endpoint(asio::ip::address_v4::loopback(), 0));
    const auto come = [&](asio::ip::tcp::socket& reader, std::string& how) {
        asio::ip::tcp::socket served(io);
        reader.connect(acceptor.local_endpoint());
        acceptor.accept(served);
        const auto viewer =
            std::make_shared<Viewer>(io.get_executor(), tcp_wire(std::move(served)), std::make_unique<Silent>(), 0.2);
        viewer->start([&how](const std::string& as, const std::string&) { how = as; });
        return viewer;
    };
    asio::ip::tcp::socket leaving(io), waiting(io);
    std::string how_left, how_waited;
    come(leaving, how_left);
    const auto waits = come(waiting, how_waited);
    leaving.close();
    io.run_for(std::chrono::seconds(2));
    EXPECT_EQ(how_left, "left");
    EXPECT_EQ(how_waited, "");
    waits->stop();
    io.run_for(std::chrono::seconds(5));
}

TEST(Restarts, AreThreeAnHour) {
    Restarts restarts;
    const Clock::time_point start = Clock::now();
    for (int i = 0; i < 3; ++i)
        EXPECT_TRUE(restarts.allows(start)) << i;
    EXPECT_FALSE(restarts.allows(start));
    EXPECT_FALSE(restarts.allows(start + std::chrono::seconds(3599)));
    EXPECT_TRUE(restarts.allows(start + std::chrono::seconds(3601)));
}

TEST(RenderChildren, GetOrdersWholeAndSayWhatTheyRendered) {
    const std::string said = testing::TempDir() + "equistream_order_" + std::to_string(::getpid());
    const std::string script =
        R"(echo '{"frames_per_second": 25}'; read -r order; printf %s "$order" > ')" + said +
        R"('; echo '{"frame": 7, "file": "a.exr", "window": "b.exr", "render_s": 1.5, "write_s": 0.25}'; exec sleep 1000)";
    asio::io_context io;
    double rate = 0;
    RenderedFrame frame;
    std::optional<RenderChild> child;
    const FrameOrder order{7, 4, 2, 1, Pose{{1, 2, 3}, glm::dquat(0.5, -0.5, 0.5, 0.5)}, glm::dvec3(0, 0, -1)};
    child.emplace(io, "/bin/sh", std::vector<std::string>{"-c", script},
                  RenderChild::Events{[&](double said_rate) {
                                          rate = said_rate;
                                          child->order(order);
                                      },
                                      [&](const RenderedFrame& made) {
                                          frame = made;
                                          io.stop();
                                      },
                                      [&](std::exception_ptr) { io.stop(); }});
    io.run_for(std::chrono::seconds(60));
    EXPECT_EQ(rate, 25);
    EXPECT_EQ(frame.frame, 7);
    EXPECT_EQ(frame.file + " " + frame.window, "a.exr b.exr");
    EXPECT_EQ(frame.render_s, 1.5);
    EXPECT_EQ(frame.write_s, 0.25);
    std::ifstream file(said);
    EXPECT_EQ(nlohmann::json::parse(file, nullptr, false),
              nlohmann::json::parse(
                  R"({"frame": 7, "spp": 4, "base_spp": 2, "window_halvings": 1, "position_m": [1.0, 2.0, 3.0],
                                        "orientation_wxyz": [0.5, -0.5, 0.5, 0.5], "gaze": [0.0, 0.0, -1.0]})"));
    std::filesystem::remove(said);
}

/// What such a script fails for.
std::string failure_of(const std::string& script) {
    asio::io_context io;
    std::exception_ptr problem;
    const RenderChild child(io, "/bin/sh", {"-c", script},
                            {[](double) {}, [](const RenderedFrame&) {}, [&](std::exception_ptr p) { problem = p; }});
    io.run_for(std::chrono::seconds(60));
    if (!problem)
        return "none";
    try {
        std::rethrow_exception(problem);
    } catch (const std::exception& error) {
        return error.what();
    }
}

TEST(RenderChildren, AnAnswerWithoutEndIsNotWaitedFor) {
    const auto start = Clock::now();
    EXPECT_EQ(failure_of("head -c 70000 /dev/zero | tr '\\0' x; exec sleep 1000"),
              "/bin/sh: expected answers of at most 65536 bytes, found a longer one");
    EXPECT_LT(seconds_since(start), 50);
}

TEST(RenderChildren, OneThatFallsSilentAndDoesNotEndIsKilled) {
    const auto start = Clock::now();
    EXPECT_EQ(failure_of("exec sleep 1000 >/dev/null"), "/bin/sh: ended by signal 9");
    EXPECT_LT(seconds_since(start), 50);
}

TEST(RenderChildren, OneThatEndsByItselfSaysNoMore) {
    EXPECT_EQ(failure_of("exit 0"), "/bin/sh: ended unexpectedly");
}

}  // namespace
}  // namespace equistream::serve
