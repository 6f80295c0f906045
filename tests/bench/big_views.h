#pragma once
/// What a headset would ask for: a 3840x1920 sphere and 1920x1080 eyes, with pictures of no scene.
#include <equistream_client/view.h>

namespace equistream::bench {

inline constexpr EquirectCamera big_sphere{3840, 1920, {}};
inline constexpr PerspectiveCamera big_view{1920, 1080, pi / 2};

/// Ramps that no two neighbouring samples share.
inline ByteImage big_picture(int channels) {
    ByteImage picture(big_sphere.width, big_sphere.height, channels);
    for (int y = 0; y < big_sphere.height; ++y)
        for (int x = 0; x < big_sphere.width; ++x)
            for (int c = 0; c < channels; ++c)
                picture.pixel(x, y)[c] = static_cast<std::uint8_t>(x * (c + 1) + y);
    return picture;
}

/// A decoder's planes.
struct BigPlanes {
    ByteImage y{big_sphere.width, big_sphere.height, 1, 100};
    ByteImage cb{big_sphere.width / 2, big_sphere.height / 2, 1, 120};
    ByteImage cr{big_sphere.width / 2, big_sphere.height / 2, 1, 140};

    YuvView view() const { return {y.view(), cb.view(), cr.view()}; }
};

}  // namespace equistream::bench
