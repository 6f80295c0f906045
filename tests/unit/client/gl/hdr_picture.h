#pragma once
/// An HDR picture of all that PQ can say, and what the CPU shows of it.
#include <equistream/colour.h>
#include <equistream/yuv.h>

#include <client/warp/gl/source_textures.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

namespace equistream::test {

/// Of HdrDisplaySettings, by what is not the default.
struct Chosen {
    std::string config{}, display{}, view{};
    double exposure_stops = 0;

    operator HdrDisplaySettings() const { return {config, display, view, exposure_stops}; }
};

/// Smooth waves from black to what is forty times white, in colours that lie within Rec.709 and beyond it.
struct HdrPicture {
    static constexpr int width = 160, height = 90;

    HdrPicture() : y(width, height, 1), cb(width / 2, height / 2, 1), cr(width / 2, height / 2, 1) {
        FloatImage light(width, height, 3);
        for (int row = 0; row < height; ++row)
            for (int x = 0; x < width; ++x)
                for (int c = 0; c < 3; ++c)
                    light.pixel(x, row)[c] = std::exp2(-8 + 13 * float(x) / width) *
                                             (1 + 0.9f * std::sin(0.15f * float(row) + 2.0f * float(c)));
        const FloatImage pq = PqEncoding().encode(light.view(), 1);
        rgb_to_pq(pq.view(), {y.view(), cb.view(), cr.view()});
    }
    PqView planes() const { return {y.view(), cb.view(), cr.view()}; }
    void upload_to(gl::SourceTextures& textures) const {
        textures.upload({.camera = PerspectiveCamera{width, height, pi / 2}}, planes());
    }

    Image<std::uint16_t> y, cb, cr;
};

inline double psnr_db(const ByteImage& rgba, const ByteImage& rgb) {
    double squares = 0;
    for (int y = 0; y < rgb.height(); ++y)
        for (int x = 0; x < rgb.width(); ++x)
            for (int c = 0; c < 3; ++c)
                squares += std::pow(double(rgba.pixel(x, y)[c]) - double(rgb.pixel(x, y)[c]), 2);
    return 10 * std::log10(255.0 * 255.0 * double(rgb.samples().size()) / std::max(squares, 1e-9));
}

inline ByteImage on_the_cpu(const HdrPicture& picture, const HdrDisplaySettings& settings) {
    return quantise_8bit(HdrDisplay(settings).to_display(pq_to_rgb(picture.planes()).view()).view());
}

}  // namespace equistream::test
