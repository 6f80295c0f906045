#pragma once
/// Between RGB images and libav's frames. What we code ourselves goes by yuv.h; any other decoded format by swscale, as
/// its tags say.
#include "libav.h"

#include <equistream/depth_code.h>
#include <equistream/stream.h>

#include <optional>

namespace equistream {

/// Tags of colours as they are coded, of an AVFrame or an AVCodecContext.
template <typename Tagged>
void tag_colour(Tagged& tagged, Transfer transfer) {
    const bool pq = transfer == Transfer::pq;
    tagged.color_range = AVCOL_RANGE_MPEG;
    tagged.color_primaries = pq ? AVCOL_PRI_BT2020 : AVCOL_PRI_BT709;
    tagged.color_trc = pq ? AVCOL_TRC_SMPTE2084 : AVCOL_TRC_IEC61966_2_1;
    tagged.colorspace = pq ? AVCOL_SPC_BT2020_NCL : AVCOL_SPC_BT709;
}

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

// All other pictures, by swscale: of one size, bicubic, accurate, the same on every processor.

/// PQ by BT.2020, of even sides, however its samples lie: in other places than ours, of more or less chroma.
bool is_pq(const AVFrame& frame);

class PictureScaler {
public:
    /// To RGB (AV_PIX_FMT_RGB24), or to our_pq: then what is scaled is is_pq().
    explicit PictureScaler(AVPixelFormat to) : to_(to) {}

    /// The frame's size must have been checked. Rebuilds its scaler when the format changes mid-stream.
    av::Frame scaled(const AVFrame& frame);

private:
    struct Format {
        int width = 0, height = 0, pixel_format = -1, matrix = -1, range = -1, chroma_location = -1;
        bool operator==(const Format&) const = default;
    };
    void prepare(const Format& format);

    AVPixelFormat to_;
    Format format_;
    av::Scaler scaler_;
};

inline constexpr AVPixelFormat our_pq = AV_PIX_FMT_YUV420P10LE;

/// `to_rgb` is asked for what is not is_our_yuv420().
ByteImage rgb_of(const AVFrame& yuv, PictureScaler& to_rgb);

// Samples of depth codes in libav's frames.

AVPixelFormat pixel_format_of(const PlaneFormat& format);

/// The frame's samples; it must have that format.
PlanesView planes_of(AVFrame& frame, const PlaneFormat& format);

/// The same of a decoded frame, which may have more planes than asked for (H.264 decodes gray with grey chroma);
/// nothing where it does not hold such samples.
std::optional<ConstPlanesView> decoded_planes(const AVFrame& frame, const PlaneFormat& format);

}  // namespace equistream
