/// The same client in a context of the test's own: it shows what the CPU shows.
#include "gl_clients.h"
#include "watched_client.h"

#include <tests/unit/client/gl/made_objects.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace equistream::test {
namespace {

int other_depths(const ClientPicture& found, const ClientPicture& expected) {
    int others = 0;
    for (std::size_t p = 0; p < found.depth_m.size(); ++p) {
        const float want = expected.depth_m[p], have = found.depth_m[p];
        others += found.origin[p] == ES_ORIGIN_SOURCE && expected.origin[p] == ES_ORIGIN_SOURCE && have != want &&
                  !(std::abs(have - want) < 1e-3f * want);
    }
    return others;
}

TEST_F(GlClients, ShowWhatTheCpuShows) {
    Client cpu(settings()), drawn(settings(ES_BACKEND_OPENGL));
    EXPECT_EQ(std::string(drawn.source().engine), "mesh");
    EXPECT_TRUE(drawn.source().has_depth);
    const es_client_request request = cpu.request(320, 200, pi / 2);
    expect_alike(cpu, drawn, request, 45, [](const ClientPicture& found, const ClientPicture& expected) {
        int other_origins = 0;
        for (std::size_t p = 0; p < found.origin.size(); ++p)
            other_origins += found.origin[p] != expected.origin[p];
        EXPECT_LT(other_origins, 0.002 * double(found.origin.size()));
        EXPECT_LT(other_depths(found, expected), 0.002 * double(found.origin.size()));
    });
}

/// The one casts rays, the other draws: of a source as coarse as this one, silhouettes differ by up to a pixel of it.
/// The second head looks along the wall and past its end; memory is used again.
TEST_F(GlClients, ShowWhatTheCpuShowsOfAScene) {
    const std::string scene = write_scene();
    es_client_settings of_cpu = settings(), of_gl = settings(ES_BACKEND_OPENGL);
    of_cpu.scene = of_gl.scene = scene.c_str();
    Client cpu(of_cpu), drawn(of_gl);
    EXPECT_EQ(std::string(drawn.source().engine), "eye-depth");
    EXPECT_TRUE(drawn.source().has_depth);
    es_client_request request = cpu.request(320, 200, pi / 2);
    std::ptrdiff_t endless = 0;
    for (const double yaw_rad : {0.0, 1.2}) {
        SCOPED_TRACE(yaw_rad);
        request.head.orientation_wxyz[0] = std::cos(yaw_rad / 2);
        request.head.orientation_wxyz[2] = std::sin(yaw_rad / 2);
        expect_alike(cpu, drawn, request, 33, [&](const ClientPicture& found, const ClientPicture& expected) {
            EXPECT_LT(other_depths(found, expected), 0.005 * double(found.origin.size()));
            EXPECT_LT(*std::ranges::min_element(found.depth_m), 5);
            EXPECT_GT(*std::ranges::min_element(found.depth_m), 0.5f);
            endless += std::ranges::count(found.depth_m, std::numeric_limits<float>::infinity());
        });
        EXPECT_EQ(glGetError(), GLenum(GL_NO_ERROR));
    }
    EXPECT_GT(endless, 0);
}

TEST_F(GlClients, ShowWhatTheCpuShowsInOddSizes) {
    Client cpu(settings()), drawn(settings(ES_BACKEND_OPENGL));
    for (const auto& [width, height] : {std::pair(161, 97), {47, 131}, {1, 1}}) {
        SCOPED_TRACE(width);
        const es_client_request request = cpu.request(width, height, pi / 2);
        ClientPicture expected[2], found[2];
        cpu.render(request, expected);
        drawn.render(request, found);
        for (int i = 0; i < 2; ++i) {
            SCOPED_TRACE(i);
            ASSERT_EQ(found[i].width, expected[i].width);
            ASSERT_EQ(found[i].height, expected[i].height);
            EXPECT_LE(found[i].width, width);
            EXPECT_LE(found[i].height, height);
            EXPECT_GE(found[i].width, std::max(1, width - 2));
            EXPECT_GE(found[i].height, std::max(1, height - 2));
            if (width == 1)
                continue;  // a single pixel may lie on either side of an edge
            EXPECT_GT(psnr_db(found[i].rgba, expected[i].rgba), 38);
        }
        EXPECT_EQ(glGetError(), GLenum(GL_NO_ERROR));
    }
}

/// Fields of view as a headset has them, in rectangles as large as was asked for, side by side.
TEST_F(GlClients, DrawTheRightWayUpAndNotBesideTheirRectangles) {
    Client client(settings(ES_BACKEND_OPENGL));
    const int width = 161, height = 99, border = 3;
    const HostPicture host({2 * width + 2 * border, height + 2 * border});
    for (const bool is_symmetric : {true, false}) {
        SCOPED_TRACE(is_symmetric);
        es_client_request request = client.request(width, height, pi / 2);
        if (!is_symmetric) {
            request.eyes[0].fov = {-0.9, 0.6, 0.5, -0.7};
            request.eyes[1].fov = {-0.6, 0.9, 0.5, -0.7};
        }
        ClientPicture eyes[2];
        client.render(request, eyes);
        host.clear();
        std::vector<std::uint8_t> expected = host.pixels();
        es_gl_target targets[2] = {host.at(border, border), host.at(border + width, border)};
        client.draw(request, targets);
        for (int i = 0; i < 2; ++i) {
            ASSERT_LE(eyes[i].width, width);
            ASSERT_LE(eyes[i].height, height);
            EXPECT_EQ(targets[i].width, eyes[i].width);
            EXPECT_EQ(targets[i].height, eyes[i].height);
            EXPECT_EQ(targets[i].fov.left, eyes[i].fov.left);
            host.draw_into(expected, eyes[i], targets[i].x, targets[i].y);
        }
        EXPECT_TRUE(host.pixels() == expected);
        const es_gl_textures textures = client.textures();
        EXPECT_NE(textures.colour, 0u);
        EXPECT_NE(textures.inverse_depth, 0u);
        EXPECT_EQ(textures.width[1], eyes[1].width);
        EXPECT_EQ(glGetError(), GLenum(GL_NO_ERROR));
    }
}

TEST_F(GlClients, WriteWhatIsKnownOfEachPixelIntoTheHostsTextures) {
    es_client_settings wanted = settings(ES_BACKEND_OPENGL);
    wanted.confidence = 1;
    Client client(wanted);
    const int width = 160, height = 100;
    const es_client_request request = client.request(width, height, pi / 2);
    ClientPicture eyes[2];
    client.render(request, eyes);
    const HostPicture host({width, height});
    const gl::Size size{width + 3, height + 1};
    const gl::Texture origin = gl::make_texture(size, GL_R8UI), depth_m = gl::make_texture(size, GL_R32F),
                      confidence = gl::make_texture(size, GL_R8);
    es_gl_target targets[2] = {host.at(0, 0), host.at(0, 0)};
    targets[1].origin = origin.name();
    targets[1].depth_m = depth_m.name();
    targets[1].confidence = confidence.name();
    client.draw(request, targets);
    const std::size_t texels = std::size_t(size.width) * std::size_t(size.height);
    std::vector<std::uint8_t> origins(texels), trusted(texels);
    std::vector<float> depths(texels);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glGetTextureImage(origin.name(), 0, GL_RED_INTEGER, GL_UNSIGNED_BYTE, GLsizei(texels), origins.data());
    glGetTextureImage(confidence.name(), 0, GL_RED, GL_UNSIGNED_BYTE, GLsizei(texels), trusted.data());
    glGetTextureImage(depth_m.name(), 0, GL_RED, GL_FLOAT, GLsizei(4 * texels), depths.data());
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const std::size_t at = std::size_t(y) * std::size_t(size.width) + std::size_t(x);
            const std::size_t p = std::size_t(y) * width + std::size_t(x);
            ASSERT_EQ(origins[at], eyes[1].origin[p]) << x << ", " << y;
            ASSERT_EQ(trusted[at], eyes[1].confidence[p]) << x << ", " << y;
            const float want = eyes[1].depth_m[p];
            ASSERT_TRUE(std::isnan(want) ? std::isnan(depths[at])
                                         : depths[at] == want || std::abs(depths[at] - want) < 1e-5f * want)
                << x << ", " << y << ": " << depths[at] << ", expected " << want;
        }
}

TEST_F(GlClients, HaveDepthWhereTheCpuHas) {
    for (const char* const engine : {"rotation", "proxy-sphere", "mesh"}) {
        SCOPED_TRACE(engine);
        es_client_settings of_cpu = settings(), of_gl = settings(ES_BACKEND_OPENGL);
        of_cpu.engine = of_gl.engine = engine;
        EXPECT_EQ(Client(of_gl).source().has_depth, Client(of_cpu).source().has_depth);
    }
    const std::string scene = write_scene();
    es_client_settings turned = settings(ES_BACKEND_OPENGL);
    turned.scene = scene.c_str();
    turned.engine = "rotation";
    EXPECT_FALSE(Client(turned).source().has_depth);
}

TEST_F(GlClients, RefuseEnginesThatTheyDoNotHave) {
    const auto complaint = [&](const char* scene, const char* engine) -> std::string {
        es_client_settings wanted = settings(ES_BACKEND_OPENGL);
        wanted.scene = scene;
        wanted.engine = engine;
        try {
            const Client client(wanted);
        } catch (const ClientError& problem) {
            EXPECT_TRUE(problem.is_input);
            return problem.what();
        }
        return "nothing was refused";
    };
    const std::string scene = write_scene();
    for (const std::string engine : {"mesh", "mesh-plain", "proxy-sphere"})
        EXPECT_EQ(complaint(scene.c_str(), engine.c_str()),
                  "engine: expected eye-depth or rotation, with a scene and ES_BACKEND_OPENGL, found '" + engine + "'");
    for (const char* const with : {static_cast<const char*>(nullptr), scene.c_str()})
        EXPECT_NE(complaint(with, "splat").find("expected a stage of the OpenGL backend, found 'splat'"),
                  std::string::npos);
}

TEST_F(GlClients, TexturesAreOfTheLastPicturesDrawnOrRendered) {
    Client client(settings(ES_BACKEND_OPENGL));
    EXPECT_THROW(client.textures(), ClientError);
    const HostPicture host({330, 100});
    es_gl_target targets[2] = {host.at(0, 0), host.at(165, 0)};
    client.draw(client.request(161, 99, pi / 2), targets);
    EXPECT_EQ(client.textures().width[0], 161) << "odd sizes are whole";
    ClientPicture eyes[2];
    client.render(client.request(80, 50, pi / 2), eyes);
    const es_gl_textures rendered = client.textures();
    GLint drawn_columns = 0;
    glGetTextureLevelParameteriv(rendered.colour, 0, GL_TEXTURE_WIDTH, &drawn_columns);
    EXPECT_EQ(drawn_columns, 80);
    EXPECT_EQ(rendered.width[0], 80);
    EXPECT_EQ(rendered.height[1], 50);
}

/// Eyes that are not symmetric, so that neither picture fills its layer. The wall is 3 m ahead.
TEST_F(GlClients, TexturesHoldThePicturesWhereTheySay) {
    const std::string scene = write_scene();
    for (const char* const with : {static_cast<const char*>(nullptr), scene.c_str()}) {
        SCOPED_TRACE(with == nullptr ? "the stream's own depth" : "a scene's");
        es_client_settings wanted = settings(ES_BACKEND_OPENGL);
        wanted.scene = with;
        Client client(wanted);
        es_client_request request = client.request(160, 100, pi / 2);
        request.eyes[0].fov = {-0.9, 0.6, 0.5, -0.7};
        request.eyes[1].fov = {-0.6, 0.8, 0.4, -0.6};
        ClientPicture eyes[2];
        client.render(request, eyes);
        const es_gl_textures textures = client.textures();
        EXPECT_GT(textures.x[1], 10);
        EXPECT_GT(textures.y[1], 10);
        for (int i = 0; i < 2; ++i) {
            SCOPED_TRACE(i);
            ASSERT_EQ(textures.width[i], eyes[i].width);
            ASSERT_EQ(textures.height[i], eyes[i].height);
            std::vector<std::uint8_t> colours(eyes[i].rgba.size());
            glGetTextureSubImage(textures.colour, 0, textures.x[i], textures.y[i], i, eyes[i].width, eyes[i].height, 1,
                                 GL_RGBA, GL_UNSIGNED_BYTE, GLsizei(colours.size()), colours.data());
            EXPECT_TRUE(colours == eyes[i].rgba);
            float corner = 0;
            glGetTextureSubImage(textures.inverse_depth, 0, textures.x[i], textures.y[i], i, 1, 1, 1,
                                 with == nullptr ? GL_RED : GL_DEPTH_COMPONENT, GL_FLOAT, sizeof corner, &corner);
            EXPECT_NEAR(corner * textures.inverse_depth_scale, 1 / 3.0, 1e-3);
        }
        EXPECT_EQ(glGetError(), GLenum(GL_NO_ERROR));
    }
}

TEST_F(GlClients, ShowHdrAtTheExposureThatWasAskedFor) {
    const synthetic::Folder streams;
    const std::string file = streams / "a.mkv";
    write_hdr(file, 0.5f);
    expect_exposure_by_stops(client_settings(file.c_str(), ES_BACKEND_OPENGL));
}

TEST_F(GlClients, HaveNoTexturesOfPicturesThatCouldNotBeDrawn) {
    Client client(settings(ES_BACKEND_OPENGL));
    const HostPicture host({330, 100});
    es_gl_target targets[2] = {host.at(0, 0), host.at(165, 0)};
    client.draw(client.request(160, 100, pi / 2), targets);
    EXPECT_EQ(client.textures().width[0], 160);
    {
        const NoMemory none;
        EXPECT_THROW(client.draw(client.request(80, 50, pi / 2), targets), ClientError);
    }
    EXPECT_THROW(client.textures(), ClientError);
}

TEST_F(GlClients, PassOverAPictureOfAnotherSizeThanItIsTaggedWith) {
    const synthetic::Folder streams;
    const std::string file = streams / "a.nut";
    write_with(file, {.other_size = {3}});
    WatchedClient watched(client_settings(file.c_str(), ES_BACKEND_OPENGL));
    expect_all_but_one_frame(watched, 3,
                             "frame 3, main: expected a picture of 384x256, as it is tagged, found 192x128");
}

TEST_F(GlClients, BeginWithTheFirstPictureOfTheSizeItIsTaggedWith) {
    const synthetic::Folder streams;
    const std::string file = streams / "a.nut";
    write_with(file, {.other_size = {0}});
    WatchedClient watched(client_settings(file.c_str(), ES_BACKEND_OPENGL));
    const Look look = watched.look(0);
    EXPECT_EQ(look.problem, "");
    EXPECT_EQ(look.state.frame, 1);
}

TEST_F(GlClients, ShowWhatWasDueOnceItCanBeDrawn) {
    es_client_settings playing = settings(ES_BACKEND_OPENGL);
    playing.paused = 0;
    WatchedClient watched(playing);
    watched.watch([](const Look& look) { return look.state.frame == 1; });
    while (watched.client.statistics().frames_received < 3)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const double display_s = watched.request.display_s;
    watched.request = watched.client.request(80, 60, pi / 2);
    watched.request.display_s = display_s + 0.06;
    try {
        const NoMemory none;
        watched.client.render(watched.request, watched.eyes);
        ADD_FAILURE() << "drawn without memory";
    } catch (const ClientError& problem) {
        EXPECT_NE(std::string(problem.what()).find("no memory"), std::string::npos) << problem.what();
        EXPECT_FALSE(problem.shown) << "neither can the frame before be drawn";
    }
    const Look look = watched.look(0);
    EXPECT_EQ(look.problem, "");
    EXPECT_EQ(look.state.frame, 2);
    EXPECT_TRUE(look.state.is_new);
    EXPECT_EQ(watched.eyes[1].width, 80);
}

}  // namespace
}  // namespace equistream::test
