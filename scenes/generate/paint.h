#pragma once
/// Painting textures: a colour per pixel from a function, strokes and letters on top, then PNG or JPEG bytes.
#include <equistream/image.h>

#include <glm/glm.hpp>

#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

namespace equistream::generate {

/// An 8-bit sRGB image (3 channels; 4 with alpha). The function gets (x, y) in [0, 1), y down, at pixel centres, and
/// returns display-referred colour in [0, 1] and coverage. Rows are painted in parallel: it must be pure.
ByteImage paint(int width, int height, int channels, const std::function<glm::vec4(glm::vec2)>& colour_at);

/// Distance from `p` to the segment a-b.
float distance_to_segment(glm::vec2 p, glm::vec2 a, glm::vec2 b);

/// 1 inside (distance < 0), 0 outside, with an edge `softness` wide.
float coverage(float distance, float softness);

/// Of letters that are 1 high.
inline constexpr float letter_width = 0.62f;

/// Distance from p to the middle lines of a text whose first letter's top left is the origin and height is 1.
/// Throws InputError for a letter it does not have.
float distance_to_text(std::string_view text, glm::vec2 p);

enum class Encoding { png, jpeg };

/// Encoded file bytes; a function of the image alone. JPEG is for opaque images only.
std::vector<std::uint8_t> encode_image(const ByteImage& image, Encoding encoding);

// Reproducible randomness: the same numbers on every machine, unlike the distributions of <random>.

/// SplitMix64 (Steele, Lea and Flood 2014).
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    std::uint64_t bits();
    float uniform() { return static_cast<float>(bits() >> 40) * 0x1p-24f; }  ///< [0, 1)
    float between(float low, float high) { return low + (high - low) * uniform(); }

private:
    std::uint64_t state_;
};

/// Cells after which noise repeats, along x and y.
struct Period {
    Period(int both) : x(both), y(both) {}
    Period(int along_x, int along_y) : x(along_x), y(along_y) {}
    int x, y;
};

/// Gradient noise in about [-1, 1] that repeats with `period`.
float noise(glm::vec2 p, Period period, std::uint32_t seed);

/// Sum of `octaves` of noise, halving the amplitude and doubling the frequency; about [-1, 1]. Repeats with `period`.
float turbulence(glm::vec2 p, Period period, int octaves, std::uint32_t seed);

}  // namespace equistream::generate
