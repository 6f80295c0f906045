#include "paint.h"

#include <equistream/error.h>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace equistream::generate {
namespace {

using Stroke = std::vector<glm::vec2>;

/// Letters as polylines in a box 1 high (y down); curves are short chords. Only what the bundled scenes write.
const std::map<char, std::vector<Stroke>>& alphabet() {
    static const Stroke open_bow{{0.6f, 0.2f}, {0.5f, 0.05f},  {0.32f, 0}, {0.12f, 0.08f}, {0, 0.32f},
                                 {0, 0.68f},   {0.12f, 0.92f}, {0.32f, 1}, {0.5f, 0.95f},  {0.6f, 0.8f}};
    static const Stroke double_bow{{0.58f, 0.17f}, {0.48f, 0.04f}, {0.3f, 0},     {0.11f, 0.06f}, {0.03f, 0.22f},
                                   {0.1f, 0.38f},  {0.3f, 0.48f},  {0.5f, 0.58f}, {0.59f, 0.75f}, {0.5f, 0.93f},
                                   {0.3f, 1},      {0.1f, 0.95f},  {0, 0.81f}};
    static const Stroke ring{{0.3f, 0},      {0.12f, 0.08f}, {0, 0.32f},    {0, 0.68f},     {0.12f, 0.92f}, {0.3f, 1},
                             {0.48f, 0.92f}, {0.6f, 0.68f},  {0.6f, 0.32f}, {0.48f, 0.08f}, {0.3f, 0}};
    static const std::map<char, std::vector<Stroke>> letters{
        {'A', {{{0, 1}, {0.31f, 0}, {0.62f, 1}}, {{0.12f, 0.62f}, {0.5f, 0.62f}}}},
        {'B',
         {{{0, 0}, {0, 1}, {0.4f, 1}, {0.56f, 0.9f}, {0.6f, 0.74f}, {0.54f, 0.58f}, {0.38f, 0.49f}, {0, 0.49f}},
          {{0.38f, 0.49f}, {0.52f, 0.4f}, {0.56f, 0.25f}, {0.5f, 0.09f}, {0.36f, 0}, {0, 0}}}},
        {'C', {open_bow}},
        {'D',
         {{{0, 0}, {0, 1}, {0.3f, 1}, {0.52f, 0.86f}, {0.6f, 0.6f}, {0.6f, 0.4f}, {0.52f, 0.14f}, {0.3f, 0}, {0, 0}}}},
        {'E', {{{0.6f, 0}, {0, 0}, {0, 1}, {0.6f, 1}}, {{0, 0.49f}, {0.46f, 0.49f}}}},
        {'F', {{{0.6f, 0}, {0, 0}, {0, 1}}, {{0, 0.49f}, {0.46f, 0.49f}}}},
        {'G', {open_bow, {{0.6f, 0.8f}, {0.6f, 0.55f}, {0.36f, 0.55f}}}},
        {'H', {{{0, 0}, {0, 1}}, {{0.6f, 0}, {0.6f, 1}}, {{0, 0.49f}, {0.6f, 0.49f}}}},
        {'I', {{{0.3f, 0}, {0.3f, 1}}}},
        {'K', {{{0, 0}, {0, 1}}, {{0.58f, 0}, {0, 0.6f}}, {{0.2f, 0.42f}, {0.6f, 1}}}},
        {'L', {{{0, 0}, {0, 1}, {0.6f, 1}}}},
        {'M', {{{0, 1}, {0, 0}, {0.3f, 0.6f}, {0.6f, 0}, {0.6f, 1}}}},
        {'N', {{{0, 1}, {0, 0}, {0.6f, 1}, {0.6f, 0}}}},
        {'O', {ring}},
        {'P', {{{0, 1}, {0, 0}, {0.4f, 0}, {0.55f, 0.1f}, {0.6f, 0.28f}, {0.55f, 0.45f}, {0.4f, 0.55f}, {0, 0.55f}}}},
        {'Q', {ring, {{0.36f, 0.72f}, {0.62f, 1.04f}}}},
        {'R',
         {{{0, 1}, {0, 0}, {0.4f, 0}, {0.55f, 0.1f}, {0.6f, 0.28f}, {0.55f, 0.43f}, {0.4f, 0.52f}, {0, 0.52f}},
          {{0.3f, 0.52f}, {0.62f, 1}}}},
        {'S', {double_bow}},
        {'T', {{{0, 0}, {0.62f, 0}}, {{0.31f, 0}, {0.31f, 1}}}},
        {'U', {{{0, 0}, {0, 0.7f}, {0.09f, 0.92f}, {0.3f, 1}, {0.51f, 0.92f}, {0.6f, 0.7f}, {0.6f, 0}}}},
        {'V', {{{0, 0}, {0.3f, 1}, {0.6f, 0}}}},
        {'W', {{{0, 0}, {0.14f, 1}, {0.31f, 0.35f}, {0.48f, 1}, {0.62f, 0}}}},
        {'Y', {{{0, 0}, {0.3f, 0.5f}, {0.6f, 0}}, {{0.3f, 0.5f}, {0.3f, 1}}}},
        {' ', {}},
    };
    return letters;
}

}  // namespace

ByteImage paint(int width, int height, int channels, const std::function<glm::vec4(glm::vec2)>& colour_at) {
    ByteImage image(width, height, channels);
    tbb::parallel_for(0, height, [&](int y) {
        for (int x = 0; x < width; ++x) {
            const glm::vec2 at((static_cast<float>(x) + 0.5f) / static_cast<float>(width),
                               (static_cast<float>(y) + 0.5f) / static_cast<float>(height));
            const glm::vec4 colour = glm::clamp(colour_at(at), 0.0f, 1.0f);
            for (int c = 0; c < channels; ++c)
                image.pixel(x, y)[c] = static_cast<std::uint8_t>(std::lround(255 * colour[c]));
        }
    });
    return image;
}

float distance_to_segment(glm::vec2 p, glm::vec2 a, glm::vec2 b) {
    const glm::vec2 ab = b - a;
    const float t = glm::clamp(glm::dot(p - a, ab) / glm::dot(ab, ab), 0.0f, 1.0f);
    return glm::length(p - a - t * ab);
}

float coverage(float distance, float softness) {
    return glm::clamp(0.5f - distance / softness, 0.0f, 1.0f);
}

float distance_to_text(std::string_view text, glm::vec2 p) {
    constexpr float letter_step = letter_width + 0.22f;
    float nearest = std::numeric_limits<float>::max();
    for (std::size_t i = 0; i < text.size(); ++i) {
        const auto letter = alphabet().find(text[i]);
        if (letter == alphabet().end())
            throw InputError(expected_found("text on a texture", "capital letters", std::string("'") + text[i] + "'"));
        const glm::vec2 in_letter = p - glm::vec2(letter_step * static_cast<float>(i), 0);
        for (const Stroke& stroke : letter->second)
            for (std::size_t k = 1; k < stroke.size(); ++k)
                nearest = std::min(nearest, distance_to_segment(in_letter, stroke[k - 1], stroke[k]));
    }
    return nearest;
}

std::vector<std::uint8_t> encode_image(const ByteImage& image, Encoding encoding) {
    const char* name = encoding == Encoding::png ? "texture.png" : "texture.jpg";
    auto output = OIIO::ImageOutput::create(name);
    if (!output)
        throw WorkError(std::string("OpenImageIO cannot write ") + name + ": " + OIIO::geterror());
    OIIO::ImageSpec spec(image.width(), image.height(), image.channels(), OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:UnassociatedAlpha", 1);  // glTF's alpha is not premultiplied
    spec.attribute("oiio:ColorSpace", "sRGB");
    spec.attribute("png:compressionLevel", 6);
    spec.attribute("compression", encoding == Encoding::png ? "zip" : "jpeg:88");
    std::vector<std::uint8_t> bytes;
    OIIO::Filesystem::IOVecOutput memory(bytes);
    OIIO::Filesystem::IOProxy* proxy = &memory;
    spec.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
    if (!output->open(name, spec) || !output->write_image(OIIO::TypeDesc::UINT8, image.samples().data()) ||
        !output->close())
        throw WorkError(std::string("OpenImageIO cannot write ") + name + ": " + output->geterror());
    return bytes;
}

namespace {

std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

std::uint32_t wrapped(int i, int period) {
    const int r = i % period;
    return static_cast<std::uint32_t>(r < 0 ? r + period : r);
}

/// Bijective mixing of 32 bits (Wellons, "lowbias32").
std::uint32_t mix32(std::uint32_t x) {
    x = (x ^ (x >> 16)) * 0x7feb352du;
    x = (x ^ (x >> 15)) * 0x846ca68bu;
    return x ^ (x >> 16);
}

/// Dot product with the lattice point's gradient, one of eight directions.
float along_gradient(std::uint32_t x, std::uint32_t row_key, float dx, float dy) {
    constexpr float h = 0.70710678f;
    constexpr float gradients[8][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {h, h}, {-h, h}, {h, -h}, {-h, -h}};
    const auto& g = gradients[mix32(x ^ row_key) >> 29];
    return g[0] * dx + g[1] * dy;
}

float quintic(float t) {
    return t * t * t * (t * (t * 6 - 15) + 10);
}

}  // namespace

std::uint64_t Random::bits() {
    state_ += 0x9e3779b97f4a7c15u;
    return mix(state_);
}

float noise(glm::vec2 p, Period period, std::uint32_t seed) {
    const glm::vec2 cell = glm::floor(p);
    const glm::vec2 f = p - cell;
    const int column = static_cast<int>(cell.x), row = static_cast<int>(cell.y);
    const std::uint32_t x0 = wrapped(column, period.x), x1 = wrapped(column + 1, period.x);
    const std::uint32_t key0 = mix32(seed + 0x9e3779b9u * wrapped(row, period.y));
    const std::uint32_t key1 = mix32(seed + 0x9e3779b9u * wrapped(row + 1, period.y));
    const float a = along_gradient(x0, key0, f.x, f.y);
    const float b = along_gradient(x1, key0, f.x - 1, f.y);
    const float c = along_gradient(x0, key1, f.x, f.y - 1);
    const float d = along_gradient(x1, key1, f.x - 1, f.y - 1);
    const float u = quintic(f.x), v = quintic(f.y);
    return 1.4f * glm::mix(glm::mix(a, b, u), glm::mix(c, d, u), v);
}

float turbulence(glm::vec2 p, Period period, int octaves, std::uint32_t seed) {
    float sum = 0, amplitude = 1, total = 0;
    for (int octave = 0; octave < octaves; ++octave) {
        sum += amplitude * noise(p, period, seed + static_cast<std::uint32_t>(octave));
        total += amplitude;
        amplitude *= 0.5f;
        p *= 2.0f;
        period = {2 * period.x, 2 * period.y};
    }
    return 1.5f * sum / total;
}

}  // namespace equistream::generate
