/// A host's context after a client has drawn in it: its state is as it was, and what could not be drawn was refused.
#include "gl_clients.h"

#include <array>
#include <climits>
#include <string>
#include <vector>

namespace equistream::test {
namespace {

constexpr GLuint viewports = 16, draw_buffers = 8, clip_planes = 8;

struct BufferTarget {
    GLenum target, binding;
};
constexpr std::array<BufferTarget, 7> buffer_targets = {
    {{GL_DISPATCH_INDIRECT_BUFFER, GL_DISPATCH_INDIRECT_BUFFER_BINDING},
     {GL_DRAW_INDIRECT_BUFFER, GL_DRAW_INDIRECT_BUFFER_BINDING},
     {GL_PARAMETER_BUFFER_ARB, GL_PARAMETER_BUFFER_BINDING_ARB},
     {GL_PIXEL_PACK_BUFFER, GL_PIXEL_PACK_BUFFER_BINDING},
     {GL_PIXEL_UNPACK_BUFFER, GL_PIXEL_UNPACK_BUFFER_BINDING},
     {GL_SHADER_STORAGE_BUFFER, GL_SHADER_STORAGE_BUFFER_BINDING},
     {GL_UNIFORM_BUFFER, GL_UNIFORM_BUFFER_BINDING}}};

struct PixelStore {
    GLenum name;
    GLint initial, disturbing;
};
constexpr std::array<PixelStore, 16> pixel_stores = {{{GL_PACK_ALIGNMENT, 4, 8},
                                                      {GL_PACK_IMAGE_HEIGHT, 0, 9},
                                                      {GL_PACK_LSB_FIRST, 0, 1},
                                                      {GL_PACK_ROW_LENGTH, 0, 7},
                                                      {GL_PACK_SKIP_IMAGES, 0, 2},
                                                      {GL_PACK_SKIP_PIXELS, 0, 5},
                                                      {GL_PACK_SKIP_ROWS, 0, 3},
                                                      {GL_PACK_SWAP_BYTES, 0, 1},
                                                      {GL_UNPACK_ALIGNMENT, 4, 8},
                                                      {GL_UNPACK_IMAGE_HEIGHT, 0, 9},
                                                      {GL_UNPACK_LSB_FIRST, 0, 1},
                                                      {GL_UNPACK_ROW_LENGTH, 0, 7},
                                                      {GL_UNPACK_SKIP_IMAGES, 0, 2},
                                                      {GL_UNPACK_SKIP_PIXELS, 0, 5},
                                                      {GL_UNPACK_SKIP_ROWS, 0, 3},
                                                      {GL_UNPACK_SWAP_BYTES, 0, 1}}};

constexpr std::array<GLenum, 6> switches = {GL_CULL_FACE,    GL_DEPTH_CLAMP,      GL_DEPTH_TEST,
                                            GL_STENCIL_TEST, GL_FRAMEBUFFER_SRGB, GL_PRIMITIVE_RESTART};

/// All that a host may have set, other than in a new context.
class DisturbedHost {
public:
    DisturbedHost() {
        glBindFramebuffer(GL_FRAMEBUFFER, bound_.framebuffer.name());
        glBindVertexArray(vertices_.name());
        for (GLuint i = 0; i < viewports; ++i) {
            const auto step = float(i);
            glViewportIndexedf(i, 1 + step, 2, 33, 44 + step);
            glScissorIndexed(i, GLint(i), 4, 5, 6);
            glDepthRangeIndexed(i, 0.25 + 0.01 * i, 0.75);
            i % 3 == 0 ? glEnablei(GL_SCISSOR_TEST, i) : glDisablei(GL_SCISSOR_TEST, i);
        }
        for (GLuint i = 0; i < draw_buffers; ++i) {
            glColorMaski(i, GL_TRUE, i % 2 == 0 ? GL_TRUE : GL_FALSE, GL_TRUE, GL_FALSE);
            i % 3 == 0 ? glEnablei(GL_BLEND, i) : glDisablei(GL_BLEND, i);
        }
        for (GLuint i = 0; i < clip_planes; i += 2)
            glEnable(GL_CLIP_DISTANCE0 + i);
        for (const GLenum on : switches)
            glEnable(on);
        glCullFace(GL_FRONT);
        glFrontFace(GL_CW);
        glDepthFunc(GL_GEQUAL);
        glDepthMask(GL_FALSE);
        glClipControl(GL_UPPER_LEFT, GL_ZERO_TO_ONE);
        glPolygonMode(GL_FRONT_AND_BACK, GL_LINE);
        glActiveTexture(GL_TEXTURE5);
        for (const PixelStore& store : pixel_stores)
            glPixelStorei(store.name, store.disturbing);
        for (std::size_t i = 0; i < buffer_targets.size(); ++i) {
            buffers_[i] = gl::make_buffer(64, 0);
            glBindBuffer(buffer_targets[i].target, buffers_[i].name());
        }
    }
    ~DisturbedHost() {
        for (const PixelStore& store : pixel_stores)
            glPixelStorei(store.name, store.initial);
    }
    DisturbedHost(const DisturbedHost&) = delete;
    DisturbedHost& operator=(const DisturbedHost&) = delete;

    static std::vector<double> state() {
        std::vector<double> all;
        const auto add = [&](GLenum what, int count) {
            std::array<GLint, 4> values{};
            glGetIntegerv(what, values.data());
            all.insert(all.end(), values.begin(), values.begin() + count);
        };
        for (const GLenum what :
             {GL_DRAW_FRAMEBUFFER_BINDING, GL_READ_FRAMEBUFFER_BINDING, GL_VERTEX_ARRAY_BINDING, GL_CURRENT_PROGRAM,
              GL_CULL_FACE_MODE, GL_FRONT_FACE, GL_DEPTH_FUNC, GL_DEPTH_WRITEMASK, GL_CLIP_ORIGIN, GL_CLIP_DEPTH_MODE,
              GL_POLYGON_MODE, GL_ACTIVE_TEXTURE})
            add(what, 1);
        for (const PixelStore& store : pixel_stores)
            add(store.name, 1);
        for (const BufferTarget& buffer : buffer_targets)
            add(buffer.binding, 1);
        for (GLuint i = 0; i < viewports; ++i) {
            std::array<GLfloat, 4> viewport{};
            std::array<GLint, 4> scissor{};
            std::array<GLdouble, 2> range{};
            glGetFloati_v(GL_VIEWPORT, i, viewport.data());
            glGetIntegeri_v(GL_SCISSOR_BOX, i, scissor.data());
            glGetDoublei_v(GL_DEPTH_RANGE, i, range.data());
            all.insert(all.end(), viewport.begin(), viewport.end());
            all.insert(all.end(), scissor.begin(), scissor.end());
            all.insert(all.end(), range.begin(), range.end());
            all.push_back(glIsEnabledi(GL_SCISSOR_TEST, i));
        }
        for (GLuint i = 0; i < draw_buffers; ++i) {
            std::array<GLboolean, 4> mask{};
            glGetBooleani_v(GL_COLOR_WRITEMASK, i, mask.data());
            all.insert(all.end(), mask.begin(), mask.end());
            all.push_back(glIsEnabledi(GL_BLEND, i));
        }
        for (GLuint i = 0; i < clip_planes; ++i)
            all.push_back(glIsEnabled(GL_CLIP_DISTANCE0 + i));
        for (const GLenum what : switches)
            all.push_back(glIsEnabled(what));
        return all;
    }

private:
    HostPicture bound_{{16, 16}};
    gl::VertexArray vertices_ = gl::make_vertex_array();
    std::array<gl::Buffer, buffer_targets.size()> buffers_;
};

/// A scene is drawn into several viewports, and the mesh of a source with its backs culled.
TEST_F(GlClients, LeaveTheHostsStateAsItWasAndDoNotHangOnIt) {
    const std::string scene = write_scene();
    for (const char* const shown : {static_cast<const char*>(nullptr), scene.c_str()}) {
        SCOPED_TRACE(shown == nullptr ? "mesh" : "scene");
        es_client_settings wanted = settings(ES_BACKEND_OPENGL);
        wanted.scene = shown;
        ClientPicture expected[2], found[2];
        const es_client_request request = Client(wanted).request(160, 100, pi / 2);
        Client(wanted).render(request, expected);
        const HostPicture host({320, 100});
        host.clear();
        std::vector<std::uint8_t> expected_host = host.pixels();
        es_gl_target targets[2] = {host.at(0, 0), host.at(160, 0)};
        {
            const DisturbedHost disturbed;
            const std::vector<double> before = DisturbedHost::state();
            {
                Client client(wanted);
                EXPECT_EQ(DisturbedHost::state(), before) << "opened";
                client.render(request, found);
                EXPECT_EQ(DisturbedHost::state(), before) << "rendered";
                client.draw(request, targets);
                EXPECT_EQ(DisturbedHost::state(), before) << "drawn";
            }
            EXPECT_EQ(DisturbedHost::state(), before) << "closed";
            EXPECT_EQ(glGetError(), GLenum(GL_NO_ERROR));
        }
        for (int i = 0; i < 2; ++i) {
            EXPECT_TRUE(found[i].rgba == expected[i].rgba);
            EXPECT_TRUE(found[i].origin == expected[i].origin);
            host.draw_into(expected_host, expected[i], targets[i].x, targets[i].y);
        }
        EXPECT_TRUE(host.pixels() == expected_host);
    }
}

TEST_F(GlClients, RefuseTargetsThatTakeNoPictureAndDrawNothing) {
    Client client(settings(ES_BACKEND_OPENGL));
    const es_client_request request = client.request(64, 48, pi / 2);
    const HostPicture good({64, 48}), whole_numbers({64, 48}, GL_RGBA8UI), shut({64, 48});
    glNamedFramebufferDrawBuffer(shut.framebuffer.name(), GL_NONE);
    good.clear();
    const gl::Framebuffer nothing = empty_framebuffer();
    const GLuint deleted = empty_framebuffer().name();
    const auto complaint = [&](const es_gl_target& second) -> std::string {
        es_gl_target targets[2] = {good.at(0, 0), second};
        try {
            client.draw(request, targets);
        } catch (const ClientError& problem) {
            EXPECT_TRUE(problem.is_input);
            return problem.what();
        }
        return "nothing was refused";
    };
    const std::string expected =
        "targets[1].framebuffer: expected a complete framebuffer with a colour attachment, not of integers, found ";
    EXPECT_EQ(complaint(target_at(deleted, 0, 0)), expected + "no framebuffer of this name");
    EXPECT_EQ(complaint(target_at(nothing.name(), 0, 0)), expected + "a framebuffer of status 0x8cd7");
    EXPECT_EQ(complaint(target_at(0, 0, 0)), expected + "a framebuffer of status 0x8219") << "there is no window";
    EXPECT_EQ(complaint(whole_numbers.at(0, 0)), expected + "no colour attachment, or one of integers");
    EXPECT_EQ(complaint(shut.at(0, 0)), expected + "no colour attachment, or one of integers");
    EXPECT_EQ(complaint(good.at(INT_MAX, 0)), "targets[1].x: expected a number from -65536 to 65536, found 2147483647");
    EXPECT_EQ(complaint(good.at(0, INT_MIN)),
              "targets[1].y: expected a number from -65536 to 65536, found -2147483648");
    es_gl_target with_plane = good.at(0, 0);
    const gl::Texture other = gl::make_texture({64, 48}, GL_R8UI);
    with_plane.depth_m = other.name();
    EXPECT_NE(complaint(with_plane)
                  .find("targets[1].depth_m: expected a GL_TEXTURE_2D with immutable storage of GL_R32F, 64x48"),
              std::string::npos);
    EXPECT_EQ(client.statistics().pictures_rendered, 0);
    EXPECT_EQ(good.pixels(), std::vector<std::uint8_t>(good.bytes(), HostPicture::untouched));
    EXPECT_EQ(complaint(good.at(-65536, 65536)), "nothing was refused") << "that lies beside the framebuffer";
    EXPECT_EQ(glGetError(), GLenum(GL_NO_ERROR));
}

/// As the header says: not into the first alone.
TEST_F(GlClients, DrawIntoAllColourBuffersThatTheFramebufferDrawsTo) {
    Client client(settings(ES_BACKEND_OPENGL));
    const es_client_request request = client.request(64, 48, pi / 2);
    const HostPicture host({128, 48});
    const gl::Texture second = gl::make_texture(host.size, GL_RGBA8);
    glNamedFramebufferTexture(host.framebuffer.name(), GL_COLOR_ATTACHMENT1, second.name(), 0);
    constexpr std::array<GLenum, 2> drawn = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    glNamedFramebufferDrawBuffers(host.framebuffer.name(), GLsizei(drawn.size()), drawn.data());
    es_gl_target targets[2] = {host.at(0, 0), host.at(64, 0)};
    client.draw(request, targets);
    std::vector<std::uint8_t> pixels(host.bytes());
    glGetTextureImage(second.name(), 0, GL_RGBA, GL_UNSIGNED_BYTE, GLsizei(pixels.size()), pixels.data());
    EXPECT_EQ(pixels, host.pixels());
    EXPECT_EQ(pixels[3], 255);
}

}  // namespace
}  // namespace equistream::test
