#pragma once
/// Between 8-bit RGB images and libav's frames. What we code ourselves goes by yuv420.h; any other decoded format by
/// swscale, as its tags say.
#include "libav.h"

#include <equistream/yuv.h>

namespace equistream {

/// A tagged, owning 4:2:0 frame. Sides are even.
av::Frame yuv_frame_of(ImageView<const std::uint8_t> rgb);

/// Whether a decoded frame is as equistream/yuv.h describes; then its planes.
bool is_our_yuv420(const AVFrame& frame);
YuvView yuv420_planes_of(const AVFrame& frame);

class YuvToRgb {
public:
    /// The frame's size must have been checked. Rebuilds its scaler when the format changes mid-stream.
    ByteImage convert(const AVFrame& yuv);

private:
    struct Format {
        int width = 0, height = 0, pixel_format = -1, matrix = -1, range = -1;
        bool operator==(const Format&) const = default;
    };
    void prepare(const Format& format);
    void scale(const AVFrame& yuv, ImageView<std::uint8_t> rgb);

    Format format_;
    av::Scaler scaler_;
    av::Frame scaled_;
};

}  // namespace equistream
