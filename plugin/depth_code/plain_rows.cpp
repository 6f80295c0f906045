#include "plain_pixels.h"

namespace equistream::depth_rows {

namespace {

std::int64_t count_too_near(std::span<const float> depth_m, const Scale& scale) {
    return std::count_if(depth_m.begin(), depth_m.end(), [&](float r) { return r < scale.near_m; });
}

template <typename T>
std::int64_t pack_w(std::span<const float> depth_m, const Scale& scale, T* samples) {
    for (std::size_t x = 0; x < depth_m.size(); ++x)
        samples[x] = static_cast<T>(whole_sample(depth_m[x], scale));
    return count_too_near(depth_m, scale);
}

template <typename T>
void unpack_w(const T* samples, const Scale& scale, std::span<float> depth_m) {
    for (std::size_t x = 0; x < depth_m.size(); ++x)
        depth_m[x] = depth_of(static_cast<float>(samples[x]), scale);
}

template <typename T>
void store(const std::array<T, 3>& samples, std::size_t x, T* const planes[3]) {
    for (std::size_t plane = 0; plane < 3; ++plane)
        planes[plane][x] = samples[plane];
}

template <typename T>
std::array<T, 3> load(const T* const planes[3], std::size_t x) {
    return {planes[0][x], planes[1][x], planes[2][x]};
}

std::int64_t pack_pece(std::span<const float> depth_m, const Scale& scale, std::uint8_t* const planes[3]) {
    for (std::size_t x = 0; x < depth_m.size(); ++x)
        store(pece_of(depth_m[x], scale), x, planes);
    return count_too_near(depth_m, scale);
}

void unpack_pece(const std::uint8_t* const planes[3], const Scale& scale, std::span<float> depth_m) {
    for (std::size_t x = 0; x < depth_m.size(); ++x)
        depth_m[x] = depth_of(pece_sample(load(planes, x)), scale);
}

std::int64_t pack_pece420(const PecePair& pair, const Scale& scale) {
    return pece420_from(pair, scale, 0);
}

void unpack_pece420(const std::uint8_t* luma, const std::uint8_t* half_wave, const Scale& scale,
                    std::span<float> depth_m) {
    for (std::size_t x = 0; x < depth_m.size(); ++x)
        depth_m[x] = depth_of(pece_sample({luma[x], 0, half_wave[x / 2]}), scale);
}

std::int64_t pack_hue(std::span<const float> depth_m, const Scale& scale, std::uint8_t* const planes[3]) {
    for (std::size_t x = 0; x < depth_m.size(); ++x)
        store(hue_of(depth_m[x], scale), x, planes);
    return count_too_near(depth_m, scale);
}

void unpack_hue(const std::uint8_t* const planes[3], const Scale& scale, std::span<float> depth_m) {
    for (std::size_t x = 0; x < depth_m.size(); ++x)
        depth_m[x] = depth_of_hue(load(planes, x), scale);
}

void pack_bits(std::span<const float> depth_m, std::uint16_t* const planes[3]) {
    for (std::size_t x = 0; x < depth_m.size(); ++x)
        store(bits_of(depth_m[x]), x, planes);
}

void unpack_bits(const std::uint16_t* const planes[3], std::span<float> depth_m) {
    for (std::size_t x = 0; x < depth_m.size(); ++x)
        depth_m[x] = depth_of_bits(load(planes, x));
}

}  // namespace

Scale::Scale(const DepthRange& range, int full_sample)
    : box_radius_m(static_cast<float>(range.box_radius_m)), near_m(static_cast<float>(range.near_m)),
      span_m(near_m - box_radius_m),
      top(static_cast<float>(range.has_empty ? full_sample - full_sample / 8 : full_sample)),
      full(static_cast<float>(full_sample)), unpack_m(span_m * top),
      last(range.has_empty ? (top + full) / 2 : std::numeric_limits<float>::infinity()), has_empty(range.has_empty) {}

Rows plain_rows() {
    return {pack_w<std::uint8_t>,
            pack_w<std::uint16_t>,
            unpack_w<std::uint8_t>,
            unpack_w<std::uint16_t>,
            pack_pece,
            unpack_pece,
            pack_pece420,
            unpack_pece420,
            pack_hue,
            unpack_hue,
            pack_bits,
            unpack_bits};
}

}  // namespace equistream::depth_rows
