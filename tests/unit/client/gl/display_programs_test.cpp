/// Whatever is shown, each of Display's programs shows what one plain shader for all of it does, bit for bit.
#include "gl_fixture.h"
#include "made_objects.h"
#include "plain_display.h"

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <numeric>
#include <random>
#include <string>
#include <tuple>
#include <vector>

namespace equistream::test {
namespace {

/// Odd sides, so that halves differ; the legend fits in.
constexpr gl::Size window{217, 181};

std::vector<std::uint8_t> random_bytes(std::size_t count, std::mt19937& random) {
    std::vector<std::uint8_t> bytes(count);
    for (std::uint8_t& byte : bytes)
        byte = std::uint8_t(random());
    return bytes;
}

std::int64_t differing(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), std::int64_t(0), std::plus(), std::not_equal_to());
}

/// All that is known of two eyes' pixels, of random values.
struct Known {
    Known(gl::DisplayLayout layout, std::mt19937& random) : size(gl::eye_size(layout, window)) {
        const std::size_t pixels = std::size_t(size.width) * std::size_t(size.height);
        for (gl::EyeTargets* to : {&eyes, &other}) {
            to->size_for({size.width, size.height, 1.5}, 2);
            fill(to->colour(), GL_RGBA, GL_UNSIGNED_BYTE, random_bytes(2 * 4 * pixels, random).data());
        }
        std::vector<std::uint8_t> origins = random_bytes(2 * pixels, random);
        for (std::uint8_t& origin : origins)
            origin %= 10;
        fill(eyes.origin(), GL_RED_INTEGER, GL_UNSIGNED_BYTE, origins.data());
        std::uniform_real_distribution<float> inverse(-0.2f, 2), moves(-2, 2);
        std::vector<float> values(2 * pixels);
        for (float& value : values)
            value = inverse(random);
        fill(depth.name(), GL_RED, GL_FLOAT, values.data());
        values.resize(2 * 3 * pixels);
        for (float& value : values)
            value = moves(random);
        fill(motion.name(), GL_RGB, GL_FLOAT, values.data());
        fill(reliability.name(), GL_RED, GL_UNSIGNED_BYTE, random_bytes(2 * pixels, random).data());
        const ByteImage sphere = [&] {
            ByteImage image(96, 48, 3);
            for (std::uint8_t& sample : image.samples())
                sample = std::uint8_t(random());
            return image;
        }();
        source.upload({.rgb = sphere.view(), .camera = EquirectCamera{96, 48, {}}});
    }
    gl::DisplayedPictures pictures(bool is_known, bool splits) const {
        return {.eyes = &eyes,
                .other = splits ? &other : nullptr,
                .depth = is_known ? gl::EyeDepth{depth.name(), 1.5f} : gl::EyeDepth{},
                .reliability = is_known ? reliability.name() : 0,
                .motion = is_known ? motion.name() : 0,
                .source = &source};
    }

    const gl::Size size;
    gl::EyeTargets eyes, other;
    gl::Texture depth = gl::make_layered_texture(size, 2, GL_R32F);
    gl::Texture motion = gl::make_layered_texture(size, 2, GL_RGBA16F);
    gl::Texture reliability = gl::make_layered_texture(size, 2, GL_R8);
    gl::SourceTextures source;

private:
    void fill(GLuint texture, GLenum format, GLenum type, const void* pixels) const {
        glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
        glTextureSubImage3D(texture, 0, 0, 0, 0, size.width, size.height, 2, format, type, pixels);
    }
};

class GlDisplayPrograms : public Gl, public testing::WithParamInterface<std::tuple<std::size_t, std::size_t>> {
protected:
    static void SetUpTestSuite() {
        Gl::SetUpTestSuite();
        display = std::make_unique<gl::Display>();
        plain = std::make_unique<PlainDisplay>();
    }
    static void TearDownTestSuite() {
        plain.reset();
        display.reset();
        Gl::TearDownTestSuite();
    }

    static inline std::unique_ptr<gl::Display> display;
    static inline std::unique_ptr<PlainDisplay> plain;
    gl::Texture shown = gl::make_texture(window, GL_RGBA8);
    gl::Framebuffer framebuffer;

    void SetUp() override {
        GLuint name = 0;
        glCreateFramebuffers(1, &name);
        framebuffer = gl::Framebuffer(name);
        glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, shown.name(), 0);
        glBindFramebuffer(GL_FRAMEBUFFER, name);
    }
    void TearDown() override { glBindFramebuffer(GL_FRAMEBUFFER, 0); }

    /// Red, green, blue and alpha.
    template <typename By>
    std::vector<std::uint8_t> drawn(const By& by, const gl::DisplayedPictures& pictures,
                                    const gl::DisplayOptions& options) {
        const std::uint8_t nobody_drew[] = {1, 2, 3, 4};
        glClearTexImage(shown.name(), 0, GL_RGBA, GL_UNSIGNED_BYTE, nobody_drew);
        by.draw(pictures, options, window);
        std::vector<std::uint8_t> pixels(std::size_t(4 * window.width * window.height));
        glReadPixels(0, 0, window.width, window.height, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
        return pixels;
    }
};

TEST_P(GlDisplayPrograms, ShowWhatOnePlainShaderShows) {
    const gl::DisplayLayout layout{int(std::get<0>(GetParam()))};
    const gl::Overlay overlay{int(std::get<1>(GetParam()))};
    std::mt19937 random(5);
    const Known known(layout, random);
    drawn(*display, known.pictures(true, true), {.layout = layout, .overlay = overlay});
    const MadeObjects made_since;
    for (const bool is_known : {true, false})
        for (const float split : {1.0f, 0.0f, 0.31f, 0.5f, 0.999f})
            for (const float fading : {0.0f, 0.37f, 1.0f}) {
                const gl::DisplayedPictures pictures = known.pictures(is_known, split < 1);
                const gl::DisplayOptions options{
                    .layout = layout, .overlay = overlay, .fading = fading, .split = split};
                EXPECT_EQ(differing(drawn(*display, pictures, options), drawn(*plain, pictures, options)), 0)
                    << "split " << split << ", fading " << fading << (is_known ? "" : ", nothing known");
            }
    EXPECT_EQ(made_since.count(), 0);
}

INSTANTIATE_TEST_SUITE_P(Window, GlDisplayPrograms,
                         testing::Combine(testing::Range(std::size_t(0), gl::display_layout_names.size()),
                                          testing::Range(std::size_t(0), gl::overlay_names.size())),
                         [](const auto& test) {
                             return std::string(gl::display_layout_names[std::get<0>(test.param)]) + "_" +
                                    std::string(gl::overlay_names[std::get<1>(test.param)]);
                         });

}  // namespace
}  // namespace equistream::test
