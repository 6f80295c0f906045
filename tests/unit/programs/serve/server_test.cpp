/// Who is let in, by a door and wires whose other ends do what the test says.
#include <programs/serve/server.h>

#include <asio/error.hpp>
#include <asio/io_context.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace equistream::serve {
namespace {

class GivenDoor : public Door {
public:
    void listen(const std::string&) override {}
    void accept(Came came) override { came_ = std::move(came); }
    void turn_away(std::unique_ptr<Wire> wire) override { turned_away.push_back(std::move(wire)); }
    void close() override { is_open_ = false; }
    bool is_open() const override { return is_open_; }
    ServerAddress address() const override { return {.host = "127.0.0.1"}; }
    void come(const std::string& from, std::unique_ptr<Wire> wire) {
        std::exchange(came_, nullptr)({}, {std::move(wire), asio::ip::make_address(from), 1000});
    }
    std::vector<std::unique_ptr<Wire>> turned_away;

private:
    Came came_;
    bool is_open_ = true;
};

class GivenWire : public Wire {
public:
    explicit GivenWire(std::vector<Opened>& arriving) : arriving_(arriving) {}
    void open(Opened opened) override { arriving_.push_back(std::move(opened)); }
    void read_some(std::span<char>, Moved moved) override { moved_ = std::move(moved); }
    void write_some(std::span<const char>, Moved) override {}
    Unacknowledged unacknowledged() override { return {}; }
    void end_writing() override {}
    void close() override { moved_ = nullptr; }

private:
    std::vector<Opened>& arriving_;
    Moved moved_;
};

struct Nothing : Feed {
    Portion next(std::span<char>, double) override { return {}; }
};
struct OfNothing : Programme {
    std::unique_ptr<Feed> open_feed() override { return std::make_unique<Nothing>(); }
};

struct Served {
    explicit Served(int viewers)
        : server(io, std::unique_ptr<Door>(door), programme,
                 {.max_viewers = viewers, .log = cli::ProgressStyle::none}) {
        server.start();
    }
    ~Served() {
        server.stop();
        arriving.clear();
        io.poll();
    }
    void come(const std::string& from) { door->come(from, std::make_unique<GivenWire>(arriving)); }
    void come_in(const std::string& from) {
        const std::size_t before = arriving.size();
        come(from);
        if (arriving.size() > before)
            arriving.back()({});
    }

    asio::io_context io;
    std::vector<Wire::Opened> arriving;
    GivenDoor* door = new GivenDoor;  // the server's
    OfNothing programme;
    Server server;
};

TEST(Servers, LetInFourOfEachAddressAndAnyNumberOfThisMachine) {
    Served served(100);
    for (int i = 0; i < 6; ++i)
        served.come_in("192.0.2.1");
    EXPECT_EQ(served.server.viewers(), 4u);
    served.come_in("::ffff:192.0.2.1");
    EXPECT_EQ(served.server.viewers(), 4u);
    for (int i = 1; i <= 6; ++i)
        served.come_in("2001:db8:0:1::" + std::to_string(i));
    EXPECT_EQ(served.server.viewers(), 8u) << "a network counts as one";
    for (int i = 0; i < 6; ++i)
        served.come_in("127.0.0.1");
    EXPECT_EQ(served.server.viewers(), 14u);
    EXPECT_EQ(served.server.figures().refused, 2 + 1 + 2);
    EXPECT_EQ(served.door->turned_away.size(), 5u);
}

TEST(Servers, WaitForSixteenOfEachAddressAndSixtyFourInAllToShowTheSecret) {
    Served served(100);
    for (int address = 1; address <= 5; ++address) {
        for (int i = 0; i < 17; ++i)
            served.come("192.0.2." + std::to_string(address));
        EXPECT_EQ(served.arriving.size(), std::size_t(std::min(64, 16 * address)));
    }
    served.arriving.front()(asio::error::eof);
    served.come("192.0.2.9");
    EXPECT_EQ(served.arriving.size(), 65u) << "who has gone makes room";
}

TEST(Servers, AskAgainWhetherThereIsRoomWhereTwoArriveAtOnce) {
    Served served(1);
    served.come("192.0.2.1");
    served.come("192.0.2.2");
    ASSERT_EQ(served.arriving.size(), 2u);
    for (const Wire::Opened& opened : served.arriving)
        opened({});
    EXPECT_EQ(served.server.viewers(), 1u);
    EXPECT_EQ(served.server.figures().refused, 1);
}

}  // namespace
}  // namespace equistream::serve
