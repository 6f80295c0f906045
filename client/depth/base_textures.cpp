#include "base_textures.h"

#include <plugin/pictures/encoded_image.h>

#include <equistream/error.h>
#include <equistream/rec709.h>

#include <algorithm>
#include <cmath>

namespace equistream {

namespace {

int wrapped(int i, int n, Wrap wrap) {
    if (wrap == Wrap::clamp)
        return std::clamp(i, 0, n - 1);
    const int period = wrap == Wrap::mirror ? 2 * n : n;
    const int m = (i % period + period) % period;
    return m < n ? m : period - 1 - m;
}

float bounded(float coordinate) {
    return std::abs(coordinate) < BaseTextures::farthest_coordinate ? coordinate : 0.0f;
}

}  // namespace

BaseTextures::BaseTextures(const SceneModel& model)
    : model_(model), chains_(std::make_unique<Chain[]>(model.textures.size())) {
    for (std::size_t i = 0; i < to_linear_.size(); ++i)
        to_linear_[i] = srgb_to_linear(float(i) / 255);
}

BaseTextures::~BaseTextures() = default;

void BaseTextures::fill(std::uint32_t texture) const {
    Chain& chain = chains_[texture];
    const Texture& from = model_.textures[texture];
    std::vector<std::uint8_t> samples;
    int width = 0, height = 0, channels = 0;
    try {
        EncodedImage image(from.encoded, from.name);
        width = image.width();
        height = image.height();
        channels = image.channels();
        samples = image.read();
    } catch (const InputError&) {
        return;  // The host renders such a scene with the material's factor alone, or not at all.
    }
    Level level{width, height, std::vector<std::uint8_t>(std::size_t(width) * height * 3)};
    for (std::size_t i = 0; i < std::size_t(width) * height; ++i)
        for (int c = 0; c < 3; ++c)
            level.rgb[3 * i + c] = samples[i * channels + (channels >= 3 ? c : 0)];
    while (true) {
        Level coarser{std::max(level.width / 2, 1), std::max(level.height / 2, 1), {}};
        const bool last = level.width == 1 && level.height == 1;
        coarser.rgb.resize(std::size_t(coarser.width) * coarser.height * 3);
        for (int y = 0; y < coarser.height; ++y)
            for (int x = 0; x < coarser.width; ++x)
                for (int c = 0; c < 3; ++c) {
                    float light = 0;
                    for (int k = 0; k < 4; ++k) {
                        const int i = std::min(2 * x + k % 2, level.width - 1);
                        const int j = std::min(2 * y + k / 2, level.height - 1);
                        light += 0.25f * to_linear_[level.rgb[3 * (std::size_t(j) * level.width + i) + c]];
                    }
                    coarser.rgb[3 * (std::size_t(y) * coarser.width + x) + c] =
                        std::uint8_t(255 * linear_to_srgb(light) + 0.5f);
                }
        if (std::max(level.width, level.height) <= longest_side)
            chain.levels.push_back(std::move(level));
        if (last)
            return;
        level = std::move(coarser);
    }
}

glm::vec3 BaseTextures::texel(const Texture& texture, const Level& level, int x, int y) const {
    const int i = wrapped(x, level.width, texture.wrap_u), j = wrapped(y, level.height, texture.wrap_v);
    const std::uint8_t* rgb = &level.rgb[3 * (std::size_t(j) * level.width + i)];
    return {to_linear_[rgb[0]], to_linear_[rgb[1]], to_linear_[rgb[2]]};
}

void BaseTextures::decode(std::uint32_t texture) const {
    std::call_once(chains_[texture].once, [&] { fill(texture); });
}

glm::vec3 BaseTextures::lookup(std::uint32_t texture, glm::vec2 uv, float footprint) const {
    decode(texture);
    const Chain& chain = chains_[texture];
    if (chain.levels.empty())
        return glm::vec3(1);
    const Level& finest = chain.levels.front();
    const float texels = std::max(footprint * float(std::max(finest.width, finest.height)), 1.0f);
    const std::size_t wanted = std::isfinite(texels) ? std::size_t(std::log2(texels) + 0.5f) : chain.levels.size();
    const Level& level = chain.levels[std::min(wanted, chain.levels.size() - 1)];
    const Texture& from = model_.textures[texture];
    const float u = bounded(uv.x) * float(level.width) - 0.5f, v = bounded(uv.y) * float(level.height) - 0.5f;
    const float left = std::floor(u), top = std::floor(v);
    const int x = int(left), y = int(top);
    const glm::vec3 above = glm::mix(texel(from, level, x, y), texel(from, level, x + 1, y), u - left);
    const glm::vec3 below = glm::mix(texel(from, level, x, y + 1), texel(from, level, x + 1, y + 1), u - left);
    return glm::mix(above, below, v - top);
}

}  // namespace equistream
