#include "gl_fixture.h"

#include <client/gpu/program.h>

#include <equistream/error.h>

#include <array>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>

namespace equistream::test {
namespace {

using GlProgram = Gl;

TEST_F(GlProgram, DriverSaysWhoItIs) {
    const gl::Driver driver = gl::Context::driver();
    EXPECT_FALSE(driver.renderer.empty());
    EXPECT_GE(driver.version, "4.5");
}

TEST(ShaderText, HoldsIncludedFilesOnce) {
    const std::string text = gl::shader_text("resample.glsl");
    EXPECT_EQ(text.find("#include"), std::string::npos);
    const std::size_t first = text.find("vec2 position_of(");
    ASSERT_NE(first, std::string::npos);
    EXPECT_EQ(text.find("vec2 position_of(", first + 1), std::string::npos);
    EXPECT_THROW(gl::shader_text("nothing.glsl"), std::logic_error);
}

TEST_F(GlProgram, MistakesCarryTheCompilersWords) {
    // Without its defines the text has undeclared names.
    try {
        gl::Program program({{GL_COMPUTE_SHADER, "resample.glsl"}});
        ADD_FAILURE() << "compiled";
    } catch (const std::logic_error& error) {
        EXPECT_NE(std::string(error.what()).find("resample.glsl"), std::string::npos);
        EXPECT_NE(std::string(error.what()).find("BY_SURFACE"), std::string::npos) << error.what();
    }
}

/// Drivers differ in what they find unused; what a text does not have at all is a slip.
TEST_F(GlProgram, WhatTheCompilerFoundUnusedIsSetWithoutEffect) {
    const gl::Program program({{GL_COMPUTE_SHADER, "unused",
                                "layout(local_size_x = 1) in;\n"
                                "uniform vec2 unread;\n"
                                "void main() {}\n"}});
    EXPECT_FALSE(program.reads("unread"));
    EXPECT_NO_THROW(program.set("unread", glm::vec2(1)));
    EXPECT_THROW(program.set("unrea", glm::vec2(1)), std::logic_error);
}

/// Before the driver is asked for it, in a line that says how much there may be.
TEST_F(GlProgram, StorageBeyondTheDriversLimitsIsRefused) {
    GLint64 max_bytes = 0;
    glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &max_bytes);
    const auto expect_refused = [](const auto& make, const char* what) {
        try {
            make();
            ADD_FAILURE() << what;
        } catch (const WorkError& error) {
            EXPECT_NE(std::string(error.what()).find(what), std::string::npos) << error.what();
            EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
        }
    };
    expect_refused([] { gl::make_texture({1 << 24, 1}, GL_R8); }, "sides of textures");
    expect_refused([] { gl::make_layered_texture({1, 1 << 24}, 2, GL_R8); }, "sides of textures");
    expect_refused([] { gl::make_layered_texture({1, 1}, 1 << 24, GL_R8); }, "layers");
    expect_refused([&] { gl::make_buffer(std::size_t(max_bytes) + 1, 0); }, "storage block");
}

/// A driver that has none left: its next error is that.
TEST_F(GlProgram, StorageThatThereIsNoMemoryForIsSaidInOneLine) {
    glGetError();
    static decltype(epoxy_glGetError) original;
    original = std::exchange(epoxy_glGetError, [] { return GLenum(GL_OUT_OF_MEMORY); });
    const auto said = [](const auto& make) -> std::string {
        try {
            make();
        } catch (const WorkError& error) {
            return error.what();
        }
        return "nothing";
    };
    const std::string texture = said([] {
        gl::make_texture({16, 8}, GL_RGBA32F);
    }),
                      layers = said([] {
                          gl::make_layered_texture({16, 8}, 3, GL_RGBA32F);
                      }),
                      buffer = said([] { gl::make_buffer(100, 0); });
    epoxy_glGetError = original;
    EXPECT_EQ(texture, "OpenGL: the driver has no memory for a texture of 16x8");
    EXPECT_EQ(layers, "OpenGL: the driver has no memory for 3 layers of 16x8");
    EXPECT_EQ(buffer, "OpenGL: the driver has no memory for a buffer of 100 bytes");
}

/// A host's, from before.
TEST_F(GlProgram, AnErrorThatIsPendingIsNotOfTheStorage) {
    glGetError();
    static int pending = 1;
    static decltype(epoxy_glGetError) original;
    original =
        std::exchange(epoxy_glGetError, [] { return pending-- > 0 ? GLenum(GL_OUT_OF_MEMORY) : GLenum(GL_NO_ERROR); });
    EXPECT_NO_THROW(gl::make_texture({16, 8}, GL_R8));
    epoxy_glGetError = original;
}

/// Rows may be farther apart than they are long.
TEST_F(GlProgram, DownloadsKeepToTheirRows) {
    const std::array<std::uint8_t, 6> content = {1, 2, 3, 4, 5, 6};
    const gl::Texture texture = gl::make_texture({3, 2}, GL_R8);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTextureSubImage2D(texture.name(), 0, 0, 0, 3, 2, GL_RED, GL_UNSIGNED_BYTE, content.data());
    std::array<std::uint8_t, 8> found;
    found.fill(9);
    gl::download(texture.name(), 0, {2, 2}, {GL_RED, GL_UNSIGNED_BYTE, 1}, found.data(), 4);
    EXPECT_EQ(found, (std::array<std::uint8_t, 8>{1, 2, 9, 9, 4, 5, 9, 9}));
}

}  // namespace
}  // namespace equistream::test
