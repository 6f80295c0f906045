#pragma once
/// Between RGB images and libav's frames. What we code ourselves goes by yuv420.h, and by yuv.h where it is HDR; any
/// other decoded format by swscale, as its tags say.
#include "libav.h"

#include <equistream/depth_code.h>
#include <equistream/yuv.h>

#include <optional>

namespace equistream {

/// A tagged, owning 4:2:0 frame. Sides are even.
av::Frame yuv_frame_of(ImageView<const std::uint8_t> rgb);
/// The same of PQ R'G'B' from 0 to 1, 10 bits a sample.
av::Frame pq_frame_of(ImageView<const float> rgb);

/// Whether a decoded frame is as equistream/yuv.h describes; then its planes.
bool is_our_yuv420(const AVFrame& frame);
YuvView yuv420_planes_of(const AVFrame& frame);
/// The same of equistream/yuv.h.
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

// HDR videos of others, whose samples lie otherwise than ours: in other places, of more or fewer of chroma, in other
// ranges.

/// PQ by BT.2020, of even sides, however its samples lie.
bool is_pq(const AVFrame& frame);

class PqScaler {
public:
    /// As equistream/yuv.h describes, by swscale. `pq` is_pq().
    av::Frame as_ours(const AVFrame& pq);

private:
    struct Format {
        int width = 0, height = 0, pixel_format = -1, range = -1, chroma_location = -1;
        bool operator==(const Format&) const = default;
    };
    void prepare(const Format& format);

    Format format_;
    av::Scaler scaler_;
};

// swscale as every conversion here has it: of one size, bicubic, accurate, the same on every processor.

/// Set up but for sws_init_context().
av::Scaler make_scaler(int width, int height, int from_pixel_format, int to_pixel_format);
/// One of swscale's own names.
void set_scaling(SwsContext& scaler, const char* option, int value);

// Samples of depth codes in libav's frames.

AVPixelFormat pixel_format_of(const PlaneFormat& format);

/// An owning frame of that format.
av::Frame make_planes(const PlaneFormat& format, int width, int height);

/// The frame's samples; it must have that format.
PlanesView planes_of(AVFrame& frame, const PlaneFormat& format);

/// The same of a decoded frame, which may have more planes than asked for (H.264 decodes gray with grey chroma);
/// nothing where it does not hold such samples.
std::optional<ConstPlanesView> decoded_planes(const AVFrame& frame, const PlaneFormat& format);

}  // namespace equistream
