#pragma once
/// What a headset would ask for: a 3840x1920 sphere and 1920x1080 eyes, with pictures of no scene.
#include <client/warp/view.h>

#include <random>

namespace equistream::bench {

inline constexpr EquirectCamera big_sphere{3840, 1920, {}};
inline constexpr PerspectiveCamera big_view{1920, 1080, pi / 2};

/// White noise: the hardest to interpolate.
inline ByteImage noise(int width, int height, int channels) {
    ByteImage picture(width, height, channels);
    std::minstd_rand random(1);
    for (std::uint8_t& sample : picture.samples())
        sample = static_cast<std::uint8_t>(random() >> 16);
    return picture;
}

inline ByteImage big_picture(int channels) {
    return noise(big_sphere.width, big_sphere.height, channels);
}

/// A decoder's planes.
struct BigPlanes {
    ByteImage y = big_picture(1);
    ByteImage cb = noise(big_sphere.width / 2, big_sphere.height / 2, 1);
    ByteImage cr = noise(big_sphere.width / 2, big_sphere.height / 2, 1);

    YuvView view() const { return {y.view(), cb.view(), cr.view()}; }
};

}  // namespace equistream::bench
