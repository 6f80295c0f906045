/// The same client in a context of the test's own: it shows what the CPU shows, and leaves the context as it was.
#include "client_folder.h"

#include <client/gpu/context.h>
#include <client/gpu/objects.h>

#include <cmath>

namespace equistream::test {
namespace {

class GlClients : public ClientFolder {
protected:
    const std::unique_ptr<gl::Context> context = gl::make_offscreen_context();

    static double psnr_db(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b) {
        double sum = 0;
        for (std::size_t i = 0; i < a.size(); ++i)
            sum += (double(a[i]) - b[i]) * (double(a[i]) - b[i]);
        return 10 * std::log10(255.0 * 255.0 / (sum / double(a.size()) + 1e-9));
    }
};

TEST_F(GlClients, ShowWhatTheCpuShows) {
    Client cpu(settings()), drawn(settings(ES_BACKEND_OPENGL));
    EXPECT_EQ(std::string(drawn.source().engine), "mesh");
    EXPECT_TRUE(drawn.source().has_depth);
    const es_client_request request = cpu.request(320, 200, pi / 2);
    ClientPicture expected[2], found[2];
    cpu.render(request, expected);
    drawn.render(request, found);
    for (int i = 0; i < 2; ++i) {
        SCOPED_TRACE(i);
        ASSERT_EQ(found[i].rgba.size(), expected[i].rgba.size());
        EXPECT_GT(psnr_db(found[i].rgba, expected[i].rgba), 45);
        int other_origins = 0, other_depths = 0;
        for (std::size_t p = 0; p < found[i].origin.size(); ++p) {
            other_origins += found[i].origin[p] != expected[i].origin[p];
            const float want = expected[i].depth_m[p];
            other_depths += found[i].origin[p] == ES_ORIGIN_SOURCE && expected[i].origin[p] == ES_ORIGIN_SOURCE &&
                            !(std::abs(found[i].depth_m[p] - want) < 1e-3f * want);
        }
        EXPECT_LT(other_origins, 0.002 * double(found[i].origin.size()));
        EXPECT_LT(other_depths, 0.002 * double(found[i].origin.size()));
    }
}

TEST_F(GlClients, DrawIntoAFramebufferTheRightWayUp) {
    Client client(settings(ES_BACKEND_OPENGL));
    const int width = 160, height = 100;
    const es_client_request request = client.request(width, height, pi / 2);
    ClientPicture eyes[2];
    client.render(request, eyes);
    const gl::Texture texture = gl::make_texture({2 * width + 7, height + 5}, GL_RGBA8);
    GLuint framebuffer = 0;
    glCreateFramebuffers(1, &framebuffer);
    const gl::Framebuffer owned(framebuffer);
    glNamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, texture.name(), 0);
    es_gl_target targets[2] = {{0, framebuffer, 3, 5, 0, 0, {}, 0, 0, 0},
                               {0, framebuffer, width + 7, 5, 0, 0, {}, 0, 0, 0}};
    client.draw(request, targets);
    EXPECT_EQ(targets[0].width, width);
    EXPECT_EQ(targets[1].height, height);
    std::vector<std::uint8_t> pixels(4 * std::size_t(2 * width + 7) * std::size_t(height + 5));
    glGetTextureImage(texture.name(), 0, GL_RGBA, GL_UNSIGNED_BYTE, GLsizei(pixels.size()), pixels.data());
    for (int i = 0; i < 2; ++i)
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                for (int c = 0; c < 4; ++c) {
                    const int column = x + (i == 0 ? 3 : width + 7), row = 5 + height - 1 - y;
                    ASSERT_EQ(pixels[4 * (std::size_t(row) * (2 * width + 7) + std::size_t(column)) + std::size_t(c)],
                              eyes[i].rgba[4 * (std::size_t(y) * width + std::size_t(x)) + std::size_t(c)]);
                }
    const es_gl_textures textures = client.textures();
    EXPECT_NE(textures.colour, 0u);
    EXPECT_NE(textures.inverse_depth, 0u);
    EXPECT_EQ(textures.width[1], width);
}

TEST_F(GlClients, WritesWhatIsKnownOfEachPixelIntoTheHostsTextures) {
    es_client_settings wanted = settings(ES_BACKEND_OPENGL);
    wanted.confidence = 1;
    Client client(wanted);
    const int width = 160, height = 100;
    const es_client_request request = client.request(width, height, pi / 2);
    ClientPicture eyes[2];
    client.render(request, eyes);
    const gl::Texture colour = gl::make_texture({width, height}, GL_RGBA8);
    GLuint framebuffer = 0;
    glCreateFramebuffers(1, &framebuffer);
    const gl::Framebuffer owned(framebuffer);
    glNamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, colour.name(), 0);
    const gl::Size size{width + 3, height + 1};
    const gl::Texture origin = gl::make_texture(size, GL_R8UI), depth_m = gl::make_texture(size, GL_R32F),
                      confidence = gl::make_texture(size, GL_R8);
    es_gl_target targets[2] = {{0, framebuffer, 0, 0, 0, 0, {}, 0, 0, 0}, {0, framebuffer, 0, 0, 0, 0, {}, 0, 0, 0}};
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
    targets[0].depth_m = origin.name();
    try {
        client.draw(request, targets);
        FAIL();
    } catch (const ClientError& problem) {
        const std::string expected =
            "targets[0].depth_m: expected a GL_TEXTURE_2D with immutable storage of GL_R32F, 160x100";
        EXPECT_NE(std::string(problem.what()).find(expected), std::string::npos) << problem.what();
    }
}

TEST_F(GlClients, LeaveTheHostsStateAsItWas) {
    Client client(settings(ES_BACKEND_OPENGL));
    const es_client_request request = client.request(160, 100, pi / 2);
    const gl::Texture texture = gl::make_texture({160, 100}, GL_RGBA8);
    GLuint names[2];
    glCreateFramebuffers(2, names);
    const gl::Framebuffer target(names[0]), bound(names[1]);
    glNamedFramebufferTexture(names[0], GL_COLOR_ATTACHMENT0, texture.name(), 0);
    glNamedFramebufferTexture(names[1], GL_COLOR_ATTACHMENT0, texture.name(), 0);
    GLuint array = 0;
    glCreateVertexArrays(1, &array);
    const gl::VertexArray vertices(array);
    const auto prepare = [&] {
        glBindFramebuffer(GL_FRAMEBUFFER, names[1]);
        glBindVertexArray(array);
        glViewport(1, 2, 33, 44);
        glScissor(3, 4, 55, 66);
        for (const GLenum on : {GL_BLEND, GL_CULL_FACE, GL_DEPTH_TEST, GL_SCISSOR_TEST, GL_FRAMEBUFFER_SRGB})
            glEnable(on);
        glDepthFunc(GL_GEQUAL);
        glClipControl(GL_UPPER_LEFT, GL_ZERO_TO_ONE);
        glColorMask(GL_TRUE, GL_FALSE, GL_TRUE, GL_FALSE);
        glDepthMask(GL_FALSE);
        glPolygonMode(GL_FRONT_AND_BACK, GL_LINE);
        glActiveTexture(GL_TEXTURE5);
    };
    const auto state = [] {
        std::vector<GLint> all;
        for (const GLenum what :
             {GL_DRAW_FRAMEBUFFER_BINDING, GL_READ_FRAMEBUFFER_BINDING, GL_VERTEX_ARRAY_BINDING, GL_VIEWPORT,
              GL_SCISSOR_BOX, GL_DEPTH_FUNC, GL_CLIP_ORIGIN, GL_CLIP_DEPTH_MODE, GL_COLOR_WRITEMASK, GL_DEPTH_WRITEMASK,
              GL_POLYGON_MODE, GL_ACTIVE_TEXTURE, GL_CURRENT_PROGRAM}) {
            std::array<GLint, 4> values{-1, -1, -1, -1};
            glGetIntegerv(what, values.data());
            all.insert(all.end(), values.begin(), values.end());
        }
        for (const GLenum what : {GL_BLEND, GL_CULL_FACE, GL_DEPTH_TEST, GL_SCISSOR_TEST, GL_FRAMEBUFFER_SRGB,
                                  GL_STENCIL_TEST, GL_DEPTH_CLAMP})
            all.push_back(glIsEnabled(what));
        return all;
    };
    es_gl_target targets[2] = {{0, names[0], 0, 0, 0, 0, {}, 0, 0, 0}, {0, names[0], 0, 0, 0, 0, {}, 0, 0, 0}};
    prepare();
    const std::vector<GLint> before = state();
    client.draw(request, targets);
    EXPECT_EQ(state(), before);
    ClientPicture eyes[2];
    client.render(request, eyes);
    EXPECT_EQ(state(), before);
    EXPECT_EQ(glGetError(), GLenum(GL_NO_ERROR));
    // What a masked colour would have left black is there.
    std::vector<std::uint8_t> pixels(4 * 160 * 100);
    glGetTextureImage(texture.name(), 0, GL_RGBA, GL_UNSIGNED_BYTE, GLsizei(pixels.size()), pixels.data());
    EXPECT_EQ(pixels[3], 255);
}

}  // namespace
}  // namespace equistream::test
