#include "coded_planes.h"

extern "C" {
#include <libavutil/pixdesc.h>
}

#include <cassert>
#include <new>

namespace equistream {

namespace {

template <typename Byte, typename Word>
AnyPlanesView<Byte, Word> view_of(const AVFrame& frame, const PlaneFormat& format) {
    AnyPlanesView<Byte, Word> planes{format};
    for (int i = 0; i < format.plane_count(); ++i) {
        const int width = frame.width / format.step(i), height = frame.height / format.step(i);
        if (format.bits == 8)
            planes.bytes[i] = {frame.data[i], width, height, 1, frame.linesize[i]};
        else
            planes.words[i] = {reinterpret_cast<Word*>(frame.data[i]), width, height, 1, frame.linesize[i] / 2};
    }
    return planes;
}

/// Whether a decoded format's first planes are such samples, one after the other.
bool holds(const AVPixFmtDescriptor& pixels, const PlaneFormat& format) {
    const bool rgb = (pixels.flags & AV_PIX_FMT_FLAG_RGB) != 0;
    if ((pixels.flags & (AV_PIX_FMT_FLAG_BE | AV_PIX_FMT_FLAG_PAL | AV_PIX_FMT_FLAG_HWACCEL | AV_PIX_FMT_FLAG_FLOAT |
                         AV_PIX_FMT_FLAG_BITSTREAM)) != 0 ||
        rgb != (format.layout == PlaneLayout::gbr) || pixels.nb_components < format.plane_count())
        return false;
    const int chroma_shift = format.layout == PlaneLayout::yuv420 ? 1 : 0;
    if (format.layout != PlaneLayout::gray &&
        (pixels.log2_chroma_w != chroma_shift || pixels.log2_chroma_h != chroma_shift))
        return false;
    for (int i = 0; i < format.plane_count(); ++i) {
        const AVComponentDescriptor& component = pixels.comp[i];
        if (component.depth != format.bits || component.shift != 0 || component.offset != 0 ||
            component.step != (format.bits == 8 ? 1 : 2))
            return false;
        // libav lists R, G, B, which lie in planes 2, 0, 1.
        const int plane = format.layout == PlaneLayout::gbr ? (i + 2) % 3 : i;
        if (component.plane != plane)
            return false;
    }
    return true;
}

}  // namespace

AVPixelFormat pixel_format_of(const PlaneFormat& format) {
    switch (format.layout) {
    case PlaneLayout::gray:
        return format.bits == 8 ? AV_PIX_FMT_GRAY8 : format.bits == 10 ? AV_PIX_FMT_GRAY10 : AV_PIX_FMT_GRAY12;
    case PlaneLayout::yuv420:
        return AV_PIX_FMT_YUV420P;
    case PlaneLayout::yuv444:
        return format.bits == 8 ? AV_PIX_FMT_YUV444P : AV_PIX_FMT_YUV444P12;
    case PlaneLayout::gbr:
        break;
    }
    return AV_PIX_FMT_GBRP;
}

av::Frame make_planes(const PlaneFormat& format, int width, int height) {
    av::Frame frame = av::make_frame();
    frame->format = pixel_format_of(format);
    frame->width = width;
    frame->height = height;
    if (av_frame_get_buffer(frame.get(), 0) < 0)
        throw std::bad_alloc();
    return frame;
}

PlanesView planes_of(AVFrame& frame, const PlaneFormat& format) {
    assert(frame.format == pixel_format_of(format));
    return view_of<std::uint8_t, std::uint16_t>(frame, format);
}

std::optional<ConstPlanesView> decoded_planes(const AVFrame& frame, const PlaneFormat& format) {
    const AVPixFmtDescriptor* pixels = av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
    if (pixels == nullptr || frame.width % 2 != 0 || frame.height % 2 != 0 || !holds(*pixels, format))
        return std::nullopt;
    return view_of<const std::uint8_t, const std::uint16_t>(frame, format);
}

}  // namespace equistream
