/// A client of the library and a live server: frames come to the one, the head's poses to the other.
#include <tests/unit/plugin/stream/synthetic.h>
#include <tests/unit/silent_server.h>

#include <equistream/client.hpp>
#include <equistream/viewer_message.h>

#include <gtest/gtest.h>

#include <fstream>
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

}  // namespace
}  // namespace equistream::test
