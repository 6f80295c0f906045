#pragma once
/// Owning images and non-owning strided views of them. Rows run from the top down, samples of a pixel are
/// interleaved. Not thread-safe beyond what std::vector gives: concurrent reads, or writes to distinct pixels.
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace equistream {

/// Largest width and height, and largest number of pixels. Readers check them before they allocate.
inline constexpr int max_image_side = 32768;
inline constexpr std::int64_t max_image_pixels = std::int64_t{1} << 28;

/// A borrowed view; the owner of `data` outlives it.
template <typename T>
struct ImageView {
    T* data = nullptr;  ///< first channel of the top left pixel
    int width = 0;
    int height = 0;
    int channels = 0;
    std::ptrdiff_t row_stride = 0;  ///< from row to row, in elements, not bytes

    T* row(int y) const {
        assert(y >= 0 && y < height);
        return data + y * row_stride;
    }
    T* pixel(int x, int y) const {
        assert(x >= 0 && x < width);
        return row(y) + static_cast<std::ptrdiff_t>(x) * channels;
    }
    operator ImageView<const T>() const { return {data, width, height, channels, row_stride}; }
};

/// An image that owns its samples; rows follow each other without gaps.
template <typename T>
class Image {
public:
    Image() = default;
    Image(int width, int height, int channels, T value = T{})
        : width_(width), height_(height), channels_(channels),
          samples_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                       static_cast<std::size_t>(channels),
                   value) {
        assert(width >= 0 && height >= 0 && channels >= 0);
    }

    int width() const { return width_; }
    int height() const { return height_; }
    int channels() const { return channels_; }
    bool empty() const { return samples_.empty(); }
    std::span<T> samples() { return samples_; }
    std::span<const T> samples() const { return samples_; }
    T* pixel(int x, int y) { return view().pixel(x, y); }
    const T* pixel(int x, int y) const { return view().pixel(x, y); }

    ImageView<T> view() {
        return {samples_.data(), width_, height_, channels_, static_cast<std::ptrdiff_t>(width_) * channels_};
    }
    ImageView<const T> view() const {
        return {samples_.data(), width_, height_, channels_, static_cast<std::ptrdiff_t>(width_) * channels_};
    }

private:
    int width_ = 0;
    int height_ = 0;
    int channels_ = 0;
    std::vector<T> samples_;
};

using FloatImage = Image<float>;
using IdImage = Image<std::uint32_t>;
using ByteImage = Image<std::uint8_t>;

}  // namespace equistream
