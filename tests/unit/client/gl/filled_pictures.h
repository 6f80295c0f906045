#pragma once
/// Pictures before and after a fill pass, on the GPU and on the CPU.
#include <client/fill/fill.h>
#include <tests/support/targets_with_depth.h>
#include <tests/unit/client/analytic_scene.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <utility>

namespace equistream::test {

inline void upload(const EyePicture& picture, int eye, const gl::EyeTargets& targets) {
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    const auto put = [&](GLuint texture, const ByteImage& image, GLenum format) {
        glTextureSubImage3D(texture, 0, 0, 0, eye, image.width(), image.height(), 1, format, GL_UNSIGNED_BYTE,
                            image.samples().data());
    };
    put(targets.colour(), picture.rgba, GL_RGBA);
    put(targets.origin(), picture.origin, GL_RED_INTEGER);
}

struct FilledPixels {
    std::int64_t count = 0;          ///< that the CPU filled
    std::int64_t other_origins = 0;  ///< in the whole picture
    double psnr_db = 0;              ///< of pixels that both filled; infinite where they are the same
    bool others_untouched = true;
};

/// What a fill pass made of `before`.
inline FilledPixels compare_filled(const EyePicture& before, const EyePicture& expected, const EyePicture& found) {
    FilledPixels result;
    double squares = 0;
    std::int64_t samples = 0;
    for (int y = 0; y < before.origin.height(); ++y)
        for (int x = 0; x < before.origin.width(); ++x) {
            const std::uint8_t *e = expected.rgba.pixel(x, y), *f = found.rgba.pixel(x, y);
            const int origin = *expected.origin.pixel(x, y);
            const bool same_origin = origin == *found.origin.pixel(x, y);
            result.other_origins += !same_origin;
            if (origin == *before.origin.pixel(x, y)) {
                result.others_untouched = result.others_untouched && (!same_origin || std::equal(e, e + 4, f));
                continue;
            }
            ++result.count;
            for (int c = 0; same_origin && c < 4; ++c, ++samples)
                squares += std::pow(e[c] - f[c], 2);
        }
    result.psnr_db = squares == 0 ? std::numeric_limits<double>::infinity()
                                  : 10 * std::log10(255.0 * 255 * double(samples) / squares);
    return result;
}

/// One fill pass's picture on the CPU.
inline EyePicture filled(const std::string& fill_pass, const FillInputs& inputs, const EyeView& eye,
                         const EyePicture& before) {
    EyePicture picture = before;
    const FillChain chain = make_fill_chain(fill_pass);
    chain[0]->set_frame(inputs);
    chain[0]->fill(eye, picture);
    return picture;
}

/// Two eyes' pictures, filled at once by `fill` (of their depth, and the targets with the pictures in), are those that
/// a fill pass on the CPU fills one by one, by their own depth or by none.
template <typename Fill>
void expect_the_cpus(const std::string& fill_pass, const FillInputs& inputs, double min_db,
                     std::span<const EyeView, 2> eyes, std::span<const EyePicture, 2> before,
                     gl::TargetsWithDepth& targets, const Fill& fill) {
    targets.size_for(eyes[0].camera, 2);
    const bool has_depth = eyes[0].depth_m.data != nullptr;
    for (int k = 0; k < 2; ++k) {
        upload(before[std::size_t(k)], k, targets);
        if (has_depth)
            targets.upload_depth(k, eyes[0].camera, eyes[std::size_t(k)].depth_m);
    }
    fill(has_depth ? targets.depth() : gl::EyeDepth{});
    for (int k = 0; k < 2; ++k) {
        const EyePicture& open = before[std::size_t(k)];
        const EyePicture expected = filled(fill_pass, inputs, eyes[std::size_t(k)], open);
        EyePicture found;
        targets.download(k, found);
        const FilledPixels pixels = compare_filled(open, expected, found);
        EXPECT_GE(pixels.psnr_db, min_db) << "eye " << k << ", " << pixels.count << " pixels";
        EXPECT_EQ(pixels.other_origins, 0) << "eye " << k << ", " << pixels.count << " pixels";
        EXPECT_TRUE(pixels.others_untouched) << "eye " << k;
    }
}

/// From picture to picture, whatever their sizes, with every eye's depth and with none: `expect` of two eyes and their
/// pictures. `depth_in_gap` is what the first eye's gaps have at a pixel, if anything else than they were made with.
template <typename DepthInGap, typename Expect>
void over_random_pictures(unsigned seed, const DepthInGap& depth_in_gap, const Expect& expect) {
    std::mt19937 random(seed);
    for (const auto& [width, height] : {std::pair{131, 77}, {64, 64}, {7, 5}, {200, 9}, {1, 1}, {97, 130}})
        for (int i = 0; i < 4; ++i) {
            SCOPED_TRACE(std::to_string(width) + "x" + std::to_string(height));
            std::array<RandomPicture, 2> made = {RandomPicture(width, height, random),
                                                 RandomPicture(width, height, random)};
            for (int y = 0; y < height; ++y)
                for (int x = 0; x < width; ++x)
                    if (const std::optional<float> depth_m = depth_in_gap(x, y);
                        depth_m && *made[0].picture.origin.pixel(x, y) == 0)
                        *made[0].depth_m.pixel(x, y) = *depth_m;
            const PerspectiveCamera camera{width, height, 1};
            const auto depth_of = [&](const RandomPicture& picture) {
                return i % 2 == 0 ? picture.depth_m.view() : ImageView<const float>{};
            };
            const std::array<EyeView, 2> eyes = {EyeView{camera, {}, depth_of(made[0])},
                                                 EyeView{camera, {{0.2, 0, 0.1}, {1, 0, 0, 0}}, depth_of(made[1])}};
            expect(eyes, std::array{made[0].picture, made[1].picture});
        }
}

// How alike two pictures of an eye are.

/// Where both show something, in dB of 255; infinite where there is no such place.
inline double psnr_where_seen(const EyePicture& a, const EyePicture& b) {
    double squares = 0;
    std::int64_t samples = 0;
    for (int y = 0; y < a.rgba.height(); ++y)
        for (int x = 0; x < a.rgba.width(); ++x) {
            if (a.origin.pixel(x, y)[0] == 0 || b.origin.pixel(x, y)[0] == 0)
                continue;
            for (int c = 0; c < 3; ++c)
                squares += std::pow(a.rgba.pixel(x, y)[c] - b.rgba.pixel(x, y)[c], 2);
            samples += 3;
        }
    return squares == 0 ? infinity : 10 * std::log10(255.0 * 255.0 * double(samples) / squares);
}

inline std::int64_t other_origins(const EyePicture& a, const EyePicture& b) {
    std::int64_t others = 0;
    for (std::size_t i = 0; i < a.origin.samples().size(); ++i)
        others += a.origin.samples()[i] != b.origin.samples()[i];
    return others;
}

}  // namespace equistream::test
