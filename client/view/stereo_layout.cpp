#include "stereo_layout.h"

#include <equistream/error.h>
#include <equistream/rec709.h>
#include <equistream/text.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <string>

namespace equistream {

namespace {

constexpr glm::mat3 rows(glm::vec3 red, glm::vec3 green, glm::vec3 blue) {
    return {red.x, green.x, blue.x, red.y, green.y, blue.y, red.z, green.z, blue.z};
}

constexpr glm::vec3 none{0, 0, 0}, red{1, 0, 0}, green{0, 1, 0}, blue{0, 0, 1};
const glm::vec3 grey(luminance(red), luminance(green), luminance(blue));

const std::array<Anaglyph, 4> kinds = {{
    {"dubois",
     rows({0.45610004f, 0.50048381f, 0.17638087f}, {-0.04008216f, -0.03782458f, -0.01575895f},
          {-0.01521607f, -0.02059714f, -0.00546856f}),
     rows({-0.0434706f, -0.08793882f, -0.00155529f}, {0.37847603f, 0.73363998f, -0.01845032f},
          {-0.07215268f, -0.11296065f, 1.2263951f})},
    {"colour", rows(red, none, none), rows(none, green, blue)},
    {"half-colour", rows(grey, none, none), rows(none, green, blue)},
    {"grey", rows(grey, none, none), rows(none, grey, grey)},
}};

/// The sRGB curve for 8-bit values, and back to the nearest.
class Curve {
public:
    Curve() {
        for (int i = 0; i < 256; ++i)
            linear_[std::size_t(i)] = srgb_to_linear(float(i) / 255);
        for (int i = 0; i < 255; ++i)
            next_[std::size_t(i)] = srgb_to_linear((float(i) + 0.5f) / 255);
    }
    glm::vec3 linear(const std::uint8_t* rgb) const { return {linear_[rgb[0]], linear_[rgb[1]], linear_[rgb[2]]}; }
    std::uint8_t display(float linear) const {
        return std::uint8_t(std::ranges::upper_bound(next_, linear) - next_.begin());
    }

private:
    std::array<float, 256> linear_{};
    std::array<float, 255> next_{};  ///< from which on a value rounds to the next
};

}  // namespace

std::span<const Anaglyph> anaglyphs() {
    return kinds;
}

const Anaglyph& find_anaglyph(std::string_view name) {
    const auto found = std::ranges::find(kinds, name, &Anaglyph::name);
    if (found != kinds.end())
        return *found;
    std::array<std::string_view, kinds.size()> names;
    std::ranges::transform(kinds, names.begin(), &Anaglyph::name);
    throw InputError(expected_found("--anaglyph", in_a_sentence(names, " or "), "'" + std::string(name) + "'"));
}

ByteImage make_anaglyph(const Anaglyph& kind, ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right) {
    assert(left.width == right.width && left.height == right.height);
    static const Curve curve;
    ByteImage both(left.width, left.height, 3);
    tbb::parallel_for(0, left.height, [&](int y) {
        for (int x = 0; x < left.width; ++x) {
            const glm::vec3 light =
                kind.from_left * curve.linear(left.pixel(x, y)) + kind.from_right * curve.linear(right.pixel(x, y));
            for (int channel = 0; channel < 3; ++channel)
                both.pixel(x, y)[channel] = curve.display(light[channel]);
        }
    });
    return both;
}

}  // namespace equistream
