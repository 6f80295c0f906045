#pragma once
/// Pictures before and after a rung, on the GPU and on the CPU.
#include <reproject/gl/eye_targets.h>

#include <equistream_client/fill.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

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

/// What a rung made of `before`.
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

/// One rung's picture on the CPU.
inline EyePicture filled(const std::string& rung, const FillInputs& inputs, const EyeView& eye,
                         const EyePicture& before) {
    EyePicture picture = before;
    const FillLadder ladder = make_fill_ladder(rung);
    ladder[0]->set_frame(inputs);
    ladder[0]->fill(eye, picture);
    return picture;
}

}  // namespace equistream::test
