#pragma once
/// Between RGB images and libav's frames. What we code ourselves goes by yuv420.h, and by pq.h where it is HDR; any
/// other decoded format by swscale, as its tags say.
#include "libav.h"

#include <equistream/pq.h>
#include <equistream/yuv.h>

namespace equistream {

/// A tagged, owning 4:2:0 frame. Sides are even.
av::Frame yuv_frame_of(ImageView<const std::uint8_t> rgb);
/// The same of PQ R'G'B' from 0 to 1, 10 bits a sample.
av::Frame pq_frame_of(ImageView<const float> rgb);

/// Whether a decoded frame is as equistream/yuv.h describes; then its planes.
bool is_our_yuv420(const AVFrame& frame);
YuvView yuv420_planes_of(const AVFrame& frame);
/// The same of equistream/pq.h.
bool is_our_pq420(const AVFrame& frame);
PqView pq420_planes_of(const AVFrame& frame);

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
