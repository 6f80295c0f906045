#include "client_folder.h"

#include <client/fill/fill.h>
#include <client/receive/receive.h>
#include <client/warp/engine.h>
#include <equistream/elapsed.h>

#include <Imath/half.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <limits>
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
        EXPECT_LE(eye.width, 300);
        EXPECT_LE(eye.height, 300);
        EXPECT_GT(std::max(eye.width, eye.height), 296);
        const double pixel = (std::tan(eye.fov.right) - std::tan(eye.fov.left)) / eye.width;
        EXPECT_NEAR((std::tan(eye.fov.up) - std::tan(eye.fov.down)) / eye.height, pixel, 1e-9) << "square";
        EXPECT_NEAR(std::tan(eye.fov.left), std::tan(-0.9), pixel);
        EXPECT_NEAR(std::tan(eye.fov.down), std::tan(-0.7), pixel);
        EXPECT_LE(eye.fov.left, -0.9 + 1e-4);
        EXPECT_GE(eye.fov.up, 0.5 - 1e-4);
    }
}

/// An asymmetric view equals its part of a larger symmetric one, which reaches as far as the left eye's left and lower
/// edges: they are the farthest from its axis.
TEST_F(Clients, FieldsOfViewThatAreNotSymmetricShowTheirPartOfOneThatIs) {
    es_client_settings judged = settings();
    judged.confidence = 1;
    Client client(judged);
    es_client_request request = client.request(300, 300, 1.5);
    request.eyes[0].fov = {-0.9, 0.6, 0.5, -0.7};
    request.eyes[1].fov = {-0.6, 0.8, 0.4, -0.6};
    ClientPicture parts[2], wholes[2];
    client.render(request, parts);
    const double focal_px = parts[0].width / (std::tan(parts[0].fov.right) - std::tan(parts[0].fov.left));
    const auto pixels_to = [&](double angle) { return int(std::lround(focal_px * std::tan(angle))); };
    const int width = -2 * pixels_to(parts[0].fov.left), height = -2 * pixels_to(parts[0].fov.down);
    client.render(client.request(width, height, 2 * std::atan(0.5 * width / focal_px)), wholes);
    for (int i = 0; i < 2; ++i) {
        SCOPED_TRACE(i);
        const ClientPicture &part = parts[i], &whole = wholes[i];
        const int left = width / 2 + pixels_to(part.fov.left), top = height / 2 - pixels_to(part.fov.up);
        EXPECT_GT(left + top, 40);
        ASSERT_EQ(whole.width, width);
        ASSERT_EQ(whole.height, height);
        ASSERT_TRUE(left >= 0 && left + part.width <= width);
        ASSERT_TRUE(top >= 0 && top + part.height <= height);
        int other_colours = 0, other_depths = 0, other_confidences = 0;
        for (int y = 0; y < part.height; ++y)
            for (int x = 0; x < part.width; ++x) {
                const std::size_t p = std::size_t(y) * std::size_t(part.width) + std::size_t(x),
                                  q = std::size_t(top + y) * std::size_t(width) + std::size_t(left + x);
                other_colours += !std::equal(&part.rgba[4 * p], &part.rgba[4 * p] + 4, &whole.rgba[4 * q]);
                other_confidences += part.confidence[p] != whole.confidence[q];
                const float found = part.depth_m[p], want = whole.depth_m[q];
                other_depths += !(found == want || std::abs(found - want) < 1e-5f * want ||
                                  (std::isnan(found) && std::isnan(want)));
            }
        EXPECT_LT(other_colours, 10) << "of " << part.width << "x" << part.height;
        EXPECT_LT(other_depths, 10);
        EXPECT_LT(other_confidences, 10);
    }
}

TEST_F(Clients, FillGapsByThePassesThatWereAskedFor) {
    es_client_settings unfilled = settings(), filled = settings();
    unfilled.fill = "none";
    filled.fill = "pushpull";
    Client leaving(unfilled), filling(filled);
    es_client_request request = leaving.request(320, 200, pi / 2);
    request.head.position_m[0] = 0.02;
    ClientPicture open[2], closed[2];
    leaving.render(request, open);
    filling.render(request, closed);
    for (int i = 0; i < 2; ++i) {
        EXPECT_GT(std::ranges::count(open[i].origin, ES_ORIGIN_GAP), 50);
        for (std::size_t p = 0; p < open[i].origin.size(); ++p) {
            const bool is_gap = open[i].origin[p] == ES_ORIGIN_GAP;
            ASSERT_EQ(open[i].rgba[4 * p + 3], is_gap ? 0 : 255) << p;
            ASSERT_EQ(int(closed[i].origin[p]), is_gap ? int(ES_ORIGIN_PUSH_PULL) : int(open[i].origin[p])) << p;
        }
    }
}

/// One in a room's floor, from beside the place that it was rendered from: it shows another part of the room there.
TEST_F(Clients, ShowMirrorsAsTheyWereAskedTo) {
    const MirrorView main(EquirectCamera{1024, 512, {}}, {});
    Frame frame;
    frame.info.camera = main.picture.camera;
    frame.planes["colour"] = linear_colour(main.picture.rgb);
    frame.planes["depth"] = main.picture.depth_m;
    frame.planes["specular"] = main.specular;
    frame.planes["virtual_depth"] = main.image_m;
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder / "centre");
    write_exr(folder / "centre" / frame_file_name(0), frame);
    Manifest manifest;
    manifest.shared = frame.info;
    manifest.planes = {"colour", "depth", "specular", "virtual_depth"};
    write_manifest(folder / "centre", manifest);

    const Pose pose{{0.1, 0.08, 0.02}, yaw_pitch(0.05, -0.5)};
    const MirrorView truth(PerspectiveCamera{320, 240, pi / 2}, pose);
    struct Seen {
        int gaps = 0, pixels = 0;
        double squares = 0;
        double share_of_gaps() const { return double(gaps) / pixels; }
        double mean_square() const { return squares / (pixels - gaps); }
    };
    const auto mirror_as = [&](const char* treatment) {
        es_client_settings mirrored = settings();
        mirrored.fill = "none";
        mirrored.mirrors = treatment;
        Client client(mirrored);
        es_client_request request = client.request(320, 240, pi / 2);
        const glm::dquat& q = pose.orientation;
        request.head = {{pose.position_m.x, pose.position_m.y, pose.position_m.z}, {q.w, q.x, q.y, q.z}};
        for (es_eye_view& eye : request.eyes)
            eye.in_head.position_m[0] = 0;
        ClientPicture eyes[2];
        client.render(request, eyes);
        Seen seen;
        for (std::size_t p = 0; p < eyes[0].origin.size(); ++p) {
            if (truth.specular.samples()[p] < 0.5f)
                continue;
            ++seen.pixels;
            seen.gaps += eyes[0].origin[p] == ES_ORIGIN_GAP;
            for (std::size_t c = 0; c < 3 && eyes[0].origin[p] != ES_ORIGIN_GAP; ++c)
                seen.squares += std::pow(double(eyes[0].rgba[4 * p + c]) - truth.picture.rgb.samples()[3 * p + c], 2);
        }
        return seen;
    };
    const Seen painted = mirror_as("surface"), opened = mirror_as("gaps"), by_image = mirror_as("images");
    EXPECT_LT(painted.share_of_gaps(), 0.02);
    EXPECT_GT(opened.share_of_gaps(), 0.5);
    EXPECT_LT(by_image.share_of_gaps(), 0.2);
    EXPECT_LT(by_image.mean_square(), 0.25 * painted.mean_square());
    EXPECT_EQ(mirror_as(nullptr).squares, by_image.squares) << "the default";
}

TEST_F(Clients, SayOfTheirSourceWhatItsFirstFrameSays) {
    const Pose pose{{0.25, 1.5, -0.5}, {0.6, 0, 0.8, 0}};
    write_frame(1, pose);
    std::filesystem::remove(folder / "centre" / frame_file_name(0));
    Client client(settings());
    const es_client_source source = client.source();
    EXPECT_NEAR(source.first_time_s, 1 / 30.0, 1e-9);
    EXPECT_EQ(source.frames_per_second, 30);
    EXPECT_NEAR(source.head_box_radius_m, 0.063 / 2, 1e-12) << "both eyes of a head that does not move";
    ClientPicture eyes[2];
    const es_client_state state = client.render(client.request(32, 24, 1.5), eyes);
    EXPECT_EQ(state.frame, 1);
    EXPECT_NEAR(state.time_s, 1 / 30.0, 1e-9);
    for (const es_pose& head : {source.first_head, state.head}) {
        for (int i = 0; i < 3; ++i)
            EXPECT_NEAR(head.position_m[i], pose.position_m[i], 1e-6);
        EXPECT_NEAR(head.orientation_wxyz[0], 0.6, 1e-6);
        EXPECT_NEAR(head.orientation_wxyz[2], 0.8, 1e-6);
    }
}

TEST_F(Clients, GoThroughARecordedSourceAndSeek) {
    es_client_settings playing = settings();
    playing.paused = 0;
    const auto start = Clock::now();
    Client client(playing);
    es_client_request request = client.request(32, 24, 1.5);
    ClientPicture eyes[2];
    es_client_state state{};
    // Display times that ascend by a refresh; reading runs in a thread of its own.
    for (int i = 0; i < 2000 && !state.is_over; ++i) {
        request.display_s += 1.0 / 60;
        state = client.render(request, eyes);
        EXPECT_NEAR(state.fraction_done, (double(state.frame) + 1) / frame_count, 1e-12);
        EXPECT_EQ(state.overdue_s, 0);
        EXPECT_EQ(state.playout_delay_s, 0);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_TRUE(state.is_over);
    EXPECT_EQ(state.frame, frame_count - 1);
    const es_client_statistics read = client.statistics();
    EXPECT_EQ(read.frames_shown, frame_count);
    std::uintmax_t bytes = 0;
    for (int index = 0; index < frame_count; ++index)
        bytes += std::filesystem::file_size(folder / "centre" / frame_file_name(index));
    EXPECT_EQ(read.bytes_received, std::int64_t(bytes));
    EXPECT_EQ(read.reconnections, 0);
    EXPECT_GT(read.decode_ms, 0);
    EXPECT_LT(read.decode_ms * frame_count, milliseconds_since(start)) << "the mean of frames read one by one";
    client.seek(1 / 30.0);
    for (int i = 0; i < 2000 && state.frame != 1; ++i) {
        request.display_s += 1e-3;
        state = client.render(request, eyes);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_EQ(state.frame, 1);
    EXPECT_NEAR(state.fraction_done, 2.0 / frame_count, 1e-12);
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

// What is refused, and in which words.

namespace {

class ClientSettings : public ClientFolder {
protected:
    static std::string complaint(const es_client_settings* settings, es_status expected = ES_BAD_INPUT) {
        es_error error{};
        es_client* client = nullptr;
        EXPECT_EQ(es_client_open(settings, &client, &error), expected);
        EXPECT_EQ(client, nullptr);
        return error.text;
    }
    void expect(const std::function<void(es_client_settings&)>& change, const std::string& words) {
        es_client_settings changed = settings();
        change(changed);
        EXPECT_EQ(complaint(&changed), words);
    }
};

TEST_F(ClientSettings, ThatAreWrongAreRefusedByName) {
    EXPECT_EQ(complaint(nullptr), "es_client_settings: expected a pointer, found NULL");
    expect([](auto& s) { s.struct_size = 8; }, "es_client_settings.struct_size: expected at least " +
                                                   std::to_string(sizeof(es_client_settings)) + ", found 8");
    expect([](auto& s) { s.abi_version = 7; }, "abi_version: expected 1, found 7");
    expect(
        [](auto& s) {
            const int any = 2;  // a C caller may store any int
            std::memcpy(&s.backend, &any, sizeof any);
        },
        "backend: expected ES_BACKEND_CPU or ES_BACKEND_OPENGL, found 2");
    expect([](auto& s) { s.source = nullptr; }, "source: expected a file, a folder or a URL, found NULL");
    expect([](auto& s) { s.engine = "warp"; },
           "engine: expected rotation, proxy-sphere, eye-depth, mesh, splat or mesh-plain, found 'warp'");
    expect([](auto& s) { s.max_extrapolation_s = std::nan(""); },
           "max_extrapolation_s: expected a number from 0 to 1, found nan");
    expect([](auto& s) { s.mirrors = "always"; }, "mirrors: expected images, gaps or surface, found 'always'");
    expect([](auto& s) { s.exposure_stops = -1; },
           folder.string() +
               ": expected an HDR stream, as HDR options are given, found a folder of frames; leave these "
               "out");
}

/// Of fields, not of the programs' options by which the same stages are chosen.
TEST_F(ClientSettings, StagesThatCannotBeHadAreRefusedByName) {
    expect([](auto& s) { s.engine = "eye-depth"; },
           "engine eye-depth: expected a scene, for the eyes' own depth, which no stream has (mesh and splat need "
           "none), found " +
               folder.string() + ", a folder of rendered frames");
    expect(
        [](auto& s) {
            s.backend = ES_BACKEND_OPENGL;
            s.fill = "hidden,spread";
        },
        "fill: expected a stage of the OpenGL backend, found 'spread'");
    expect(
        [](auto& s) {
            s.backend = ES_BACKEND_OPENGL;
            s.engine = "splat";
        },
        "engine: expected a stage of the OpenGL backend, found 'splat'");
}

TEST_F(ClientSettings, SourcesThatAreNotThereAreNamed) {
    es_client_settings gone = settings();
    gone.source = "/nowhere/walk.mp4";
    EXPECT_NE(complaint(&gone).find("/nowhere/walk.mp4"), std::string::npos);
    gone.source = "/nowhere/\x1b[31m\nwalk.mp4";
    EXPECT_NE(complaint(&gone).find("/nowhere/?[31m walk.mp4"), std::string::npos) << complaint(&gone);
}

/// Read by the Embree module: what it throws comes back as a status, across two libraries.
TEST_F(ClientSettings, AModelThatCannotBeReadIsNamed) {
    std::ofstream(folder / "room.glb") << "no model";
    const std::string scene = (folder / "room.json").string();
    std::ofstream(scene) << R"({"model": "room.glb", "camera": {"keys": [{"time_s": 0, "position_m": [0, 0, 0]}]}})";
    es_client_settings with_scene = settings();
    with_scene.scene = scene.c_str();
    EXPECT_NE(complaint(&with_scene).find("room.glb"), std::string::npos);
}

TEST_F(ClientSettings, AnotherSceneThanTheFramesIsRefused) {
    const std::string scene = (folder / "hall.json").string();
    std::ofstream(folder / "hall.glb") << "no model";
    std::ofstream(scene) << R"({"model": "hall.glb", "camera": {"keys": [{"time_s": 0, "position_m": [0, 0, 0]}]}})";
    es_client_settings with_scene = settings();
    with_scene.scene = scene.c_str();
    EXPECT_NE(complaint(&with_scene).find("expected the scene 'room' that"), std::string::npos);
}

TEST_F(ClientSettings, RequestsThatAreWrongAreRefusedAndChangeNothing) {
    Client client(settings());
    const es_client_request good = client.request(64, 48, 1.5);
    const auto refused = [&](const std::function<void(es_client_request&)>& change) -> std::string {
        es_client_request changed = good;
        change(changed);
        ClientPicture eyes[2];
        try {
            client.render(changed, eyes);
        } catch (const ClientError& error) {
            EXPECT_TRUE(error.is_input);
            return error.what();
        }
        return "nothing was refused";
    };
    EXPECT_EQ(refused([](auto& r) { r.head.position_m[2] = 1e19; }).substr(0, 16), "head.position_m:");
    EXPECT_EQ(refused([](auto& r) { r.eyes[1].in_head.orientation_wxyz[0] = 0; }).substr(0, 33),
              "eyes[1].in_head.orientation_wxyz:");
    EXPECT_EQ(refused([](auto& r) { r.eyes[0].fov = {0.5, -0.5, 0.5, -0.5}; }).substr(0, 12), "eyes[0].fov:");
    EXPECT_EQ(refused([](auto& r) { r.eyes[0].fov.up = std::numeric_limits<double>::infinity(); }).substr(0, 12),
              "eyes[0].fov:");
    EXPECT_EQ(refused([](auto& r) { r.width = 0; }), "width: expected 1 to 16384, found 0");
    EXPECT_EQ(refused([](auto& r) { r.width = -1; }), "width: expected 1 to 16384, found -1");
    EXPECT_EQ(refused([](auto& r) { r.height = INT32_MAX; }), "height: expected 1 to 16384, found 2147483647");
    EXPECT_EQ(refused([](auto& r) { r.display_s = -1; }).substr(0, 10), "display_s:");
    EXPECT_EQ(client.statistics().pictures_rendered, 0);
}

TEST_F(ClientSettings, AStrideThatIsTooShortIsRefused) {
    Client client(settings());
    const es_client_request request = client.request(64, 48, 1.5);
    std::vector<std::uint8_t> pixels(4 * 64 * 48);
    es_eye_image images[2] = {};
    for (es_eye_image& image : images) {
        image.struct_size = sizeof image;
        image.pixels = pixels.data();
        image.pixels_stride = 4 * 63;
    }
    EXPECT_THROW(client.render(request, images), ClientError);
}

TEST_F(ClientSettings, WhatOpenGlAloneCanDoIsRefusedOfTheCpu) {
    Client client(settings());
    es_gl_target targets[2] = {};
    const es_client_request request = client.request(64, 48, 1.5);
    EXPECT_THROW(client.draw(request, targets), ClientError);
    EXPECT_THROW(client.textures(), ClientError);
}

TEST_F(ClientSettings, NothingIsDoneWithoutAClient) {
    es_client_close(nullptr);
    es_client_pause(nullptr);
    EXPECT_EQ(es_client_now_s(nullptr), 0);
    es_error error{};
    EXPECT_EQ(es_client_seek(nullptr, 0, &error), ES_BAD_INPUT);
    EXPECT_EQ(std::string(error.text), "client: expected a pointer, found NULL");
}

}  // namespace
}  // namespace equistream::test
