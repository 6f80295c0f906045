/// What is refused, and in which words.
#include "client_folder.h"

#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <limits>

namespace equistream::test {
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
}

TEST_F(ClientSettings, SourcesThatAreNotThereAreNamed) {
    es_client_settings gone = settings();
    gone.source = "/nowhere/walk.mp4";
    EXPECT_NE(complaint(&gone).find("/nowhere/walk.mp4"), std::string::npos);
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
