/// A server that does not answer, or says nothing, is given up in time, and the reason is told. Tiles that a server
/// sends while they are looked at.
#include <client/receive/receive.h>
#include <client/transport/server_connection.h>
#include <client/warp/engine.h>
#include <tests/unit/plugin/stream/synthetic.h>
#include <tests/unit/silent_server.h>

#include <equistream/error.h>
#include <equistream/tile_stream.h>

#include <dlfcn.h>
#include <netdb.h>

#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <thread>
#include <tuple>

/// Instead of the system's: this name has two addresses, of which every machine has both.
extern "C" int getaddrinfo(const char* name, const char* service, const addrinfo* hints, addrinfo** found) {
    static const auto of_system = reinterpret_cast<decltype(&getaddrinfo)>(::dlsym(RTLD_NEXT, "getaddrinfo"));
    if (name == nullptr || std::string_view(name) != "two-homes.test")
        return of_system(name, service, hints, found);
    const int error = of_system("127.0.0.1", service, hints, found);
    return error != 0 ? error : of_system("127.0.0.2", service, hints, &(*found)->ai_next);
}

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

TEST(Poses, AreSentAgainWhereTheViewHasChanged) {
    std::vector<std::optional<ViewExtent>> views;
    PoseSender poses;
    poses.use([&](std::span<const std::uint8_t> bytes) {
        views.push_back(ViewerMessageReader().take(bytes).value().view);
        return true;
    });
    const auto send = [&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(40));  // they come at most 30 times a second
        return poses.send({});
    };
    EXPECT_TRUE(send());
    EXPECT_FALSE(send()) << "nothing has changed";
    const PerspectiveCamera camera{64, 48, 1.5};
    poses.look_through(camera);
    EXPECT_TRUE(send());
    EXPECT_FALSE(send());
    ASSERT_EQ(views.size(), 2u);
    EXPECT_FALSE(views[0]);
    EXPECT_EQ(views[1], extent_of(camera));
}

TEST(Poses, AreAtMost30ASecond) {
    int sent = 0;
    PoseSender poses;
    poses.use([&](auto) {
        ++sent;
        return true;
    });
    const auto start = Clock::now();
    for (double x_m = 0; seconds_since(start) < 0.5; x_m += 1e-3)
        poses.send({0, {{x_m, 0, 0}, {1, 0, 0, 0}}});
    EXPECT_GE(sent, 2);
    EXPECT_LE(sent, 1 + 30 * seconds_since(start));
}

TEST(ServerConnections, AServerThatDoesNotAnswerIsGivenUp) {
    SilentServer server(0);
    server.fill_up(0);
    PoseSender poses;
    EXPECT_EQ(failure_of([&] { ServerConnection(server.address(), &poses, {}, impatient); }),
              server.address() + ": the server did not answer for 0.3 s");
}

TEST(ServerConnections, TheSecondAddressIsTriedWhereTheFirstDoesNotAnswer) {
    std::optional<SilentServer> first(0);
    SilentServer second(4, "127.0.0.2", first->port());
    first->fill_up(0);
    const std::string address = "tcp://two-homes.test:" + std::to_string(second.port());
    for (const char* state : {"says nothing", "refuses"}) {
        SCOPED_TRACE(state);
        ServerConnection connection(address, nullptr, {}, {.connect_s = 1});
        second.send("all");
        std::array<std::uint8_t, 16> bytes{};
        EXPECT_EQ(connection.read(bytes), 3u);
        first.reset();
    }
}

/// A live server that has rendered one sphere shows it: libav alone would read eight of them first.
TEST(ServerConnections, TheFirstPictureOfALiveStreamIsShownAsItComes) {
    std::string bytes;
    StreamSettings settings;
    settings.preset = "ultrafast";
    settings.tracks = {{TrackRole::main, 192, 96}};
    settings.live = true;
    StreamWriter writer("live.mkv", settings, StreamTap{[&](std::span<const std::uint8_t> more) {
                            bytes.append(reinterpret_cast<const char*>(more.data()), more.size());
                        }});
    writer.begin_group();
    writer.write(TrackRole::main, synthetic::picture(192, 96, 3).view(), synthetic::info(192, 96, 3));
    writer.flush();
    SilentServer server;
    std::thread sends([&] { server.send(bytes); });
    ServerConnection connection(server.address(), nullptr, {}, impatient);
    StreamReadOptions options;
    options.read = [&](std::span<std::uint8_t> wanted) { return connection.read(wanted); };
    StreamReader reader(server.address(), options);
    const auto picture = reader.next();
    ASSERT_TRUE(picture && picture->info);
    EXPECT_EQ(picture->info->index, 3);
    sends.join();
}

TEST(ServerConnections, AServerThatSaysNothingIsGivenUp) {
    SilentServer server;
    PoseSender poses;
    ServerConnection connection(server.address(), &poses, {}, impatient);
    std::array<std::uint8_t, 16> bytes{};
    EXPECT_EQ(failure_of([&] { connection.read(bytes); }), "the server sent nothing for 0.4 s");
    EXPECT_EQ(connection.read(bytes), 0u) << "it stays so";
}

TEST(ServerConnections, AServerThatFallsSilentIsGivenUp) {
    SilentServer server;
    PoseSender poses;
    ServerConnection connection(server.address(), &poses, {}, impatient);
    server.send("all");
    std::array<std::uint8_t, 16> bytes{};
    EXPECT_EQ(connection.read(bytes), 3u);
    EXPECT_EQ(failure_of([&] { connection.read(bytes); }), "the server sent nothing for 0.2 s");
}

TEST(ServerConnections, WhoeverReadsSeldomDoesNotCallTheServerSilent) {
    SilentServer server;
    PoseSender poses;
    ServerConnection connection(server.address(), &poses, {}, impatient);
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
    options.poses = nullptr;
    EXPECT_EQ(failure_of([&] { open_feed(server.address(), options)->next(); }), expected);
    sending.join();
}

/// The thread sanitizer sees whether the socket is closed under whoever sends.
TEST(ServerConnections, HeadsMayBeSentWhileTheServerIsGivenUp) {
    SilentServer server;
    PoseSender poses;
    ServerConnection connection(server.address(), &poses, {}, impatient);
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

/// Of tiles of 64x64 of a sphere of 512x256, what is sent that is looked at in each frame; of the first frame all are.
class SentTiles : public testing::Test {
protected:
    /// Which part of the sphere is looked at in this frame, in pixels.
    struct Part {
        std::set<int> tiles;
        WindowPlace place;
        int width = 64;
    };
    static Part looked_at(std::int64_t index) {
        if (index < 6)
            return {{9, 10}, {64, 64}, 128};
        return index < 13 ? Part{{20}, {256, 128}} : Part{{15, 8}, {448, 64}, 128};  // across the seam
    }
    std::string sent(const std::string& name) const {
        synthetic::write(folder_ / name, made_);
        const auto recording = open_tiles((folder_ / name).string()).value();
        TileSender sender(recording);
        std::string bytes;
        while (const auto due_s = sender.due_s())
            sender.next(looked_at(std::llround(*due_s * 30)).tiles, bytes);
        return bytes;
    }
    static void expect_part(const ReceivedPicture& picture, std::int64_t index, const Part& part) {
        const WindowGrid grid{512, 256, part.width, 64};
        ASSERT_TRUE(same_camera(picture.info.camera, window_camera(grid, part.place)));
        EXPECT_TRUE(same_pose(picture.info.camera_pose, synthetic::info(512, 256, index).camera_pose));
        const ByteImage sphere = synthetic::picture(512, 256, index);
        ByteImage expected(part.width, 64, 3);
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < part.width; ++x)
                std::copy_n(sphere.pixel((part.place.x + x) % 512, part.place.y + y), 3, expected.pixel(x, y));
        EXPECT_GT(synthetic::psnr_db(picture.rgb, expected), 30);
    }

    synthetic::Folder folder_;
    synthetic::MadeTiles made_{.grid = {8, 4}, .pictures = 20, .gop = 8, .first_index = 0};
};

TEST_F(SentTiles, GoWithTheFramesThatTheyAreLookedAtIn) {
    for (const bool connects_itself : {false, true}) {
        const std::string bytes = sent(connects_itself ? "a.mkv" : "a.mp4");
        auto server = std::make_unique<SilentServer>();
        PoseSender poses;
        const std::string address = server->address();
        std::thread sending([&] {
            server->send(bytes);
            server.reset();
        });
        const auto feed = open_feed(address, {.poses = connects_itself ? &poses : nullptr});
        for (std::int64_t index = 0; index < 20; ++index) {
            SCOPED_TRACE(index);
            const auto frame = feed->next();
            if (!frame) {
                ADD_FAILURE();
                break;
            }
            EXPECT_EQ(frame->main.info.index, index);
            if (index == 0) {
                EXPECT_FALSE(frame->base);
                EXPECT_TRUE(same_camera(frame->main.info.camera, EquirectCamera{512, 256, {}}));
                continue;
            }
            EXPECT_TRUE(frame->base) << "a sphere around what is looked at";
            expect_part(frame->main, index, looked_at(index));
        }
        EXPECT_FALSE(feed->next());
        EXPECT_EQ(feed->truncation(), "") << "tiles that are not looked at are not missing";
        sending.join();
    }
}

/// Pictures that are coded before earlier ones: those of tiles may come and go a little beside main's.
TEST_F(SentTiles, AreSoundWhereverTheyCome) {
    made_.depth = true;
    for (const auto& [name, codec, preset] : {std::tuple("a.mkv", Codec::h264, "veryfast"),
                                              {"a.mkv", Codec::h265, "ultrafast"},
                                              {"a.mp4", Codec::h265, "ultrafast"}}) {
        SCOPED_TRACE(std::string(name) + ", " + preset);
        made_.codec = codec;
        made_.preset = preset;
        const std::string bytes = sent(name);
        auto server = std::make_unique<SilentServer>();
        const std::string address = server->address();
        std::thread sending([&] {
            server->send(bytes);
            server.reset();
        });
        const auto feed = open_feed(address, {.depth = true});
        std::int64_t index = 0, parts = 0;
        while (const auto frame = feed->next()) {
            SCOPED_TRACE(index);
            EXPECT_EQ(frame->main.info.index, index);
            const auto& camera = std::get<EquirectCamera>(frame->main.info.camera);
            EXPECT_FALSE(frame->main.depth_m.empty()) << "tiles without their depth are none";
            if (frame->base && camera.height == 64 && camera.width <= 128) {
                ++parts;
                expect_part(frame->main, index,
                            {{}, window_place({512, 256, camera.width, 64}, camera.range).value(), camera.width});
            }
            ++index;
        }
        EXPECT_EQ(index, 20);
        EXPECT_GE(parts, 12) << "others have all tiles, or those of two moments";
        EXPECT_EQ(feed->truncation(), "");
        sending.join();
    }
}

TEST(Poses, AreToldToAnotherServerAnew) {
    PoseSender poses;
    for (int server = 0; server < 2; ++server) {
        poses.use([](auto) { return true; });
        EXPECT_TRUE(poses.send({})) << server;
        EXPECT_FALSE(poses.send({})) << "the same, at once";
    }
}

}  // namespace
}  // namespace equistream::test
