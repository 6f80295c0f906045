#include "gl_fixture.h"

#include <gl/program.h>

#include <reproject/float_math.h>

#include <stdexcept>

namespace equistream::test {
namespace {

using GlProgram = Gl;

TEST_F(GlProgram, DriverSaysWhoItIs) {
    const gl::Driver driver = gl::Context::driver();
    EXPECT_FALSE(driver.renderer.empty());
    EXPECT_GE(driver.version, "4.5");
}

TEST(ShaderText, HoldsIncludedFilesOnce) {
    const std::string text = gl::shader_text("look_up.glsl");
    EXPECT_EQ(text.find("#include"), std::string::npos);
    const std::size_t first = text.find("vec2 position_of(");
    ASSERT_NE(first, std::string::npos);
    EXPECT_EQ(text.find("vec2 position_of(", first + 1), std::string::npos);
    EXPECT_THROW(gl::shader_text("nothing.glsl"), std::logic_error);
}

TEST_F(GlProgram, MistakesCarryTheCompilersWords) {
    // Without its defines the text has undeclared names.
    try {
        gl::Program program({{GL_COMPUTE_SHADER, "look_up.glsl"}});
        ADD_FAILURE() << "compiled";
    } catch (const std::logic_error& error) {
        EXPECT_NE(std::string(error.what()).find("look_up.glsl"), std::string::npos);
        EXPECT_NE(std::string(error.what()).find("MOST_EYES"), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace equistream::test
