#include "client_folder.h"

#include <client/fill/fill.h>
#include <client/receive/receive.h>
#include <client/warp/engine.h>

#include <Imath/half.h>

#include <cmath>
#include <cstring>
#include <thread>

namespace equistream::test {
namespace {

using Clients = ClientFolder;

/// As the parts make it: engine mesh, then push-pull.
EyePicture made_by_parts(const std::string& folder, const PerspectiveCamera& camera, const Pose& pose) {
    const auto feed = open_feed(folder, {.depth = true, .yuv = true, .specular = true});
    const ReceivedFrame frame = *feed->next();
    const SourceView source = source_view(frame.main, frame.main.depth_m);
    const auto engine = make_engine("mesh");
    engine->set_source(source);
    EyePicture picture;
    const EyeView eye{camera, pose};
    engine->reproject(eye, picture);
    const FillChain chain = make_fill_chain("pushpull");
    chain[0]->set_frame({.main = &source});
    fill_gaps(chain, eye, picture);
    return picture;
}

TEST_F(Clients, ShowsWhatThePartsMakeOfTheFrame) {
    Client client(settings());
    const es_client_source source = client.source();
    EXPECT_EQ(std::string(source.engine), "mesh");
    EXPECT_EQ(source.width, columns);
    EXPECT_TRUE(source.has_depth && source.has_poses && !source.is_live);
    EXPECT_NEAR(source.ipd_m, 0.063, 1e-12);
    es_client_request request = client.request(320, 200, pi / 2);
    request.head.position_m[0] = 0.02;
    ClientPicture eyes[2];
    const es_client_state state = client.render(request, eyes);
    EXPECT_EQ(state.frame, 0);
    EXPECT_TRUE(state.is_paused);
    for (int i = 0; i < 2; ++i) {
        SCOPED_TRACE(i);
        ASSERT_EQ(eyes[i].width, 320);
        ASSERT_EQ(eyes[i].height, 200);
        EXPECT_NEAR(eyes[i].fov.right, pi / 4, 1e-9);
        const EyePicture expected =
            made_by_parts(folder.string(), {320, 200, pi / 2}, {{0.02 + (i - 0.5) * 0.063, 0, 0}, {1, 0, 0, 0}});
        EXPECT_TRUE(std::ranges::equal(eyes[i].rgba, expected.rgba.samples()));
        EXPECT_TRUE(std::ranges::equal(eyes[i].origin, expected.origin.samples()));
        EXPECT_GT(expected.count(PixelOrigin::push_pull), 50);
        for (std::size_t p = 0; p < eyes[i].depth_m.size(); ++p) {
            const float want = expected.depth_m.samples()[p], found = eyes[i].depth_m[p];
            ASSERT_TRUE(want == found || (std::isnan(want) && std::isnan(found)));
        }
    }
    EXPECT_GT(client.statistics().gaps, 0);
}

TEST_F(Clients, HalvesAreTheSameValues) {
    Client client(settings());
    const es_client_request request = client.request(64, 48, 1.5);
    ClientPicture eyes[2];
    client.render(request, eyes);
    std::vector<std::uint16_t> halves(4 * 64 * 48);
    es_eye_image images[2] = {};
    for (es_eye_image& image : images) {
        image.struct_size = sizeof image;
        image.format = ES_RGBA_HALF;
    }
    images[1].pixels = halves.data();
    client.render(request, images);
    for (std::size_t i = 0; i < halves.size(); ++i) {
        Imath::half half;
        half.setBits(halves[i]);
        ASSERT_NEAR(float(half), float(eyes[1].rgba[i]) / 255, 3e-4) << i;
    }
}

/// Unlike halves of a view, as headsets have them: the picture is the part of a larger symmetric one.
TEST_F(Clients, FieldsOfViewNeedNotBeSymmetric) {
    Client client(settings());
    es_client_request request = client.request(300, 300, 1.5);
    for (es_eye_view& eye : request.eyes)
        eye.fov = {-0.9, 0.6, 0.5, -0.7};
    ClientPicture eyes[2];
    client.render(request, eyes);
    for (const ClientPicture& eye : eyes) {
        EXPECT_LE(eye.width, 301);
        EXPECT_LE(eye.height, 301);
        EXPECT_GT(std::max(eye.width, eye.height), 296);
        const double pixel = (std::tan(eye.fov.right) - std::tan(eye.fov.left)) / eye.width;
        EXPECT_NEAR((std::tan(eye.fov.up) - std::tan(eye.fov.down)) / eye.height, pixel, 1e-9) << "square";
        EXPECT_NEAR(std::tan(eye.fov.left), std::tan(-0.9), pixel);
        EXPECT_NEAR(std::tan(eye.fov.down), std::tan(-0.7), pixel);
        EXPECT_LE(eye.fov.left, -0.9 + 1e-4);
        EXPECT_GE(eye.fov.up, 0.5 - 1e-4);
    }
}

TEST_F(Clients, GoThroughARecordedSourceAndSeek) {
    es_client_settings playing = settings();
    playing.paused = 0;
    Client client(playing);
    es_client_request request = client.request(32, 24, 1.5);
    ClientPicture eyes[2];
    es_client_state state{};
    // Display times that ascend by a refresh; reading runs in a thread of its own.
    for (int i = 0; i < 2000 && !state.is_over; ++i) {
        request.display_s += 1.0 / 60;
        state = client.render(request, eyes);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_TRUE(state.is_over);
    EXPECT_EQ(state.frame, frame_count - 1);
    EXPECT_EQ(client.statistics().frames_shown, frame_count);
    client.seek(1 / 30.0);
    for (int i = 0; i < 2000 && state.frame != 1; ++i) {
        request.display_s += 1e-3;
        state = client.render(request, eyes);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_EQ(state.frame, 1);
}

TEST_F(Clients, ConfidenceIsThereWhereItWasAskedFor) {
    es_client_settings judged = settings();
    judged.confidence = 1;
    Client client(judged);
    const es_client_request request = client.request(160, 120, 1.5);
    ClientPicture eyes[2];
    client.render(request, eyes);
    EXPECT_GT(*std::ranges::max_element(eyes[0].confidence), 200);
    EXPECT_GT(client.statistics().mean_confidence, 0.5);
    EXPECT_LT(client.statistics().mean_confidence, 1);
}

TEST_F(Clients, AnEyeBeyondTheHeadBoxIsSaid) {
    Client client(settings());
    es_client_request request = client.request(32, 24, 1.5);
    ClientPicture eyes[2];
    EXPECT_FALSE(client.render(request, eyes).is_outside_box);
    request.head.position_m[1] = 0.5;
    EXPECT_TRUE(client.render(request, eyes).is_outside_box);
}

}  // namespace
}  // namespace equistream::test
