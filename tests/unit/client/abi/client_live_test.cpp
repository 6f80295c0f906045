/// A client of the library and a live server: frames come to the one, the head's poses to the other.
#include <tests/unit/client/view/paced_server.h>
#include <tests/unit/plugin/stream/synthetic.h>
#include <tests/unit/silent_server.h>

#include <equistream/client.hpp>
#include <equistream/viewer_message.h>

#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <iterator>
#include <thread>

namespace equistream::test {
namespace {

std::string bytes_of(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

TEST(LiveClients, ShowWhatAServerSendsAndTellItWhereTheHeadIs) {
    const synthetic::Folder folder;
    synthetic::write(folder / "a.mkv", synthetic::small_stream(Codec::h264, false));
    const std::string stream = bytes_of(folder / "a.mkv");
    const ViewerPose expected{0, {{0.25, -0.5, 1}, {0.6, 0, 0.8, 0}}, extent_of(PerspectiveCamera{64, 48, 1.5})};
    SilentServer server;
    std::vector<std::uint8_t> heard;
    std::thread sending([&] {
        server.send(stream);
        heard = server.hear(encode_viewer_pose(expected).size());
    });
    {
        const std::string address = server.address();
        Client client(address.c_str());
        const es_client_source source = client.source();
        EXPECT_TRUE(source.is_live && source.has_poses);
        EXPECT_EQ(source.width, 192);
        ClientPicture eyes[2];
        const es_client_state state = client.render(client.request(64, 48, 1.5), eyes);
        EXPECT_GE(state.frame, 5);
        EXPECT_FALSE(state.is_lost);
        EXPECT_EQ(eyes[0].width, 64);
        EXPECT_EQ(eyes[1].origin[64 * 24 + 32], ES_ORIGIN_SOURCE);
        EXPECT_GT(client.statistics().frames_received, 0);
        try {
            client.seek(0);
            ADD_FAILURE() << "a live source was sought in";
        } catch (const ClientError& problem) {
            EXPECT_NE(std::string(problem.what()).find("a recorded source"), std::string::npos) << problem.what();
        }
        es_pose head{};
        for (int i = 0; i < 3; ++i)
            head.position_m[i] = expected.head.position_m[i];
        head.orientation_wxyz[0] = 0.6;
        head.orientation_wxyz[2] = 0.8;
        client.send_head(head);
        sending.join();
    }
    const auto told = ViewerMessageReader().take(heard);
    ASSERT_TRUE(told) << "of " << heard.size() << " bytes";
    EXPECT_EQ(told->head.position_m, expected.head.position_m);
    EXPECT_NEAR(told->head.orientation.w, 0.6, 1e-12);
    EXPECT_NEAR(told->head.orientation.y, 0.8, 1e-12);
    ASSERT_TRUE(told->view);
    EXPECT_NEAR(told->view->half_width, expected.view->half_width, 1e-12);
    EXPECT_NEAR(told->view->half_height, expected.view->half_height, 1e-12);
}

/// Display times of the test's own may run ahead of the clock: nothing comes meanwhile.
TEST(LiveClients, SayForHowLongNothingHasComeAndThatTheServerCameBack) {
    constexpr int pictures = 24;
    const std::vector<std::vector<char>> parts = coded(pictures);
    std::int64_t bytes = 0;
    for (const std::vector<char>& part : parts)
        bytes += std::int64_t(part.size());
    PacedServer server;
    server.give(parts, 0, pictures / 2);
    const std::string address = server.address();
    const auto start = Clock::now();
    Client client(address.c_str());
    ClientPicture eyes[2];
    es_client_request request = client.request(16, 12, 1.5);
    const auto look_until = [&](const std::function<bool(const es_client_state&)>& is_so) {
        es_client_state state{};
        while (seconds_since(start) < 60) {
            request.display_s = client.now_s();
            state = client.render(request, eyes);
            if (is_so(state))
                return state;
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        ADD_FAILURE() << "nothing came of it within a minute";
        return state;
    };
    const es_client_state silent = look_until([](const es_client_state& state) { return state.overdue_s > 1; });
    EXPECT_LT(silent.overdue_s, seconds_since(start));
    request.display_s += 0.25;
    EXPECT_NEAR(client.render(request, eyes).overdue_s, silent.overdue_s + 0.25, 1e-9);
    EXPECT_GE(silent.playout_delay_s, 0.005);
    EXPECT_LE(silent.playout_delay_s, 0.25);
    EXPECT_EQ(silent.fraction_done, 0) << "the end is not known";
    EXPECT_EQ(client.statistics().reconnections, 0);
    EXPECT_GT(client.statistics().bytes_received, 0);
    EXPECT_LT(client.statistics().bytes_received, bytes / 2);
    server.close();
    look_until([](const es_client_state& state) { return state.is_lost != 0; });
    server.give(parts, 0, pictures);
    server.end();
    look_until([&](const es_client_state&) { return client.statistics().reconnections > 0; });
    EXPECT_EQ(client.statistics().reconnections, 1);
}

}  // namespace
}  // namespace equistream::test
