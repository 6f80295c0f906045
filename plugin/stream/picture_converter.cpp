#include "picture_converter.h"

#include <equistream/error.h>

#include <algorithm>
#include <cassert>
#include <new>

extern "C" {
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
}

namespace equistream {

namespace {

template <typename T>
Yuv420View<T> planes_of(const AVFrame& frame) {
    const auto plane = [&](int i, int width, int height) {
        return ImageView<T>{reinterpret_cast<T*>(frame.data[i]), width, height, 1,
                            frame.linesize[i] / std::ptrdiff_t(sizeof(T))};
    };
    return {plane(0, frame.width, frame.height), plane(1, frame.width / 2, frame.height / 2),
            plane(2, frame.width / 2, frame.height / 2)};
}

/// Untagged video: BT.709 from 720 rows on, as players assume.
int matrix_of(const AVFrame& frame) {
    if (frame.colorspace == AVCOL_SPC_UNSPECIFIED)
        return frame.height >= 720 ? SWS_CS_ITU709 : SWS_CS_ITU601;
    return frame.colorspace;
}

/// Of planes as we write them ourselves.
bool lies_as_ours(const AVFrame& frame) {
    return frame.width % 2 == 0 && frame.height % 2 == 0 && frame.color_range != AVCOL_RANGE_JPEG &&
           (frame.chroma_location == AVCHROMA_LOC_LEFT || frame.chroma_location == AVCHROMA_LOC_UNSPECIFIED);
}

av::Frame tagged_frame(AVPixelFormat format, int width, int height, Transfer transfer) {
    av::Frame yuv = av::make_frame(format, width, height);
    yuv->chroma_location = AVCHROMA_LOC_LEFT;
    tag_colour(*yuv, transfer);
    return yuv;
}

/// Of chroma's samples within luma's grid, in 256ths of a pixel; as swscale has it.
struct ChromaPlace {
    int x = 0, y = 128;
};

ChromaPlace place_of(int location) {
    switch (location) {
    case AVCHROMA_LOC_CENTER:
        return {128, 128};
    case AVCHROMA_LOC_TOPLEFT:
        return {0, 0};
    case AVCHROMA_LOC_TOP:
        return {128, 0};
    case AVCHROMA_LOC_BOTTOMLEFT:
        return {0, 256};
    case AVCHROMA_LOC_BOTTOM:
        return {128, 256};
    default:
        return {};
    }
}

/// One of swscale's own names.
void set_scaling(SwsContext& scaler, const char* option, int value) {
    [[maybe_unused]] const int code = av_opt_set_int(&scaler, option, value, 0);
    assert(code >= 0);
}

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

bool is_our_yuv420(const AVFrame& frame) {
    return frame.format == AV_PIX_FMT_YUV420P && lies_as_ours(frame) && matrix_of(frame) == SWS_CS_ITU709;
}

bool is_our_pq420(const AVFrame& frame) {
    return frame.format == AV_PIX_FMT_YUV420P10LE && lies_as_ours(frame) && frame.color_trc == AVCOL_TRC_SMPTE2084 &&
           frame.colorspace == AVCOL_SPC_BT2020_NCL;
}

PqView pq420_planes_of(const AVFrame& frame) {
    return planes_of<const std::uint16_t>(frame);
}

av::Frame pq_frame_of(ImageView<const float> rgb) {
    av::Frame yuv = tagged_frame(our_pq, rgb.width, rgb.height, Transfer::pq);
    rgb_to_pq(rgb, planes_of<std::uint16_t>(*yuv));
    return yuv;
}

YuvView yuv420_planes_of(const AVFrame& frame) {
    return planes_of<const std::uint8_t>(frame);
}

av::Frame yuv_frame_of(ImageView<const std::uint8_t> rgb) {
    av::Frame yuv = tagged_frame(AV_PIX_FMT_YUV420P, rgb.width, rgb.height, Transfer::srgb);
    rgb_to_yuv420(rgb, planes_of<std::uint8_t>(*yuv));
    return yuv;
}

bool is_pq(const AVFrame& frame) {
    return frame.color_trc == AVCOL_TRC_SMPTE2084 && frame.colorspace == AVCOL_SPC_BT2020_NCL && frame.width % 2 == 0 &&
           frame.height % 2 == 0 && sws_isSupportedInput(static_cast<AVPixelFormat>(frame.format)) > 0;
}

void PictureScaler::prepare(const Format& format) {
    if (scaler_ && format == format_)
        return;
    scaler_.reset(sws_alloc_context());
    if (!scaler_)
        throw std::bad_alloc();
    for (const char* option : {"srcw", "dstw"})
        set_scaling(*scaler_, option, format.width);
    for (const char* option : {"srch", "dsth"})
        set_scaling(*scaler_, option, format.height);
    set_scaling(*scaler_, "src_format", format.pixel_format);
    set_scaling(*scaler_, "dst_format", to_);
    set_scaling(*scaler_, "sws_flags",
                SWS_BICUBIC | SWS_ACCURATE_RND | SWS_BITEXACT | SWS_FULL_CHR_H_INT | SWS_FULL_CHR_H_INP);
    const AVPixFmtDescriptor& lies = *av_pix_fmt_desc_get(static_cast<AVPixelFormat>(format.pixel_format));
    const bool pq = to_ == our_pq;
    if (pq) {
        const ChromaPlace from = place_of(format.chroma_location), to;
        // Where chroma is whole it has no place of its own.
        if (lies.log2_chroma_w > 0)
            set_scaling(*scaler_, "src_h_chr_pos", from.x);
        if (lies.log2_chroma_h > 0)
            set_scaling(*scaler_, "src_v_chr_pos", from.y);
        set_scaling(*scaler_, "dst_h_chr_pos", to.x);
        set_scaling(*scaler_, "dst_v_chr_pos", to.y);
    }
    if (sws_init_context(scaler_.get(), nullptr, nullptr) < 0)
        throw WorkError(std::string(pq ? "no conversion of PQ" : "no conversion to RGB") + " from pixel format " +
                        lies.name);
    sws_setColorspaceDetails(scaler_.get(), sws_getCoefficients(format.matrix), format.range == AVCOL_RANGE_JPEG,
                             sws_getCoefficients(pq ? SWS_CS_BT2020 : SWS_CS_ITU709), pq ? 0 : 1, 0, 1 << 16, 1 << 16);
    format_ = format;
}

av::Frame PictureScaler::scaled(const AVFrame& frame) {
    prepare({frame.width, frame.height, frame.format, matrix_of(frame), frame.color_range, frame.chroma_location});
    av::Frame scaled = av::make_frame(to_, frame.width, frame.height);
    if (const int code = sws_scale_frame(scaler_.get(), scaled.get(), &frame); code < 0)
        throw WorkError((to_ == our_pq ? "conversion of PQ: " : "conversion to RGB: ") + av::error_text(code));
    return scaled;
}

ByteImage rgb_of(const AVFrame& yuv, PictureScaler& to_rgb) {
    ByteImage rgb(yuv.width, yuv.height, 3);
    if (is_our_yuv420(yuv)) {
        yuv420_to_rgb(yuv420_planes_of(yuv), rgb.view());
        return rgb;
    }
    // swscale touches bytes beyond the ends of rows: it gets a padded frame of libav's own.
    const av::Frame scaled = to_rgb.scaled(yuv);
    for (int y = 0; y < rgb.height(); ++y)
        std::copy_n(scaled->data[0] + std::ptrdiff_t{y} * scaled->linesize[0], 3 * rgb.width(), rgb.pixel(0, y));
    return rgb;
}

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
