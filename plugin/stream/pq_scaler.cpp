#include "pq_scaler.h"

#include <equistream/error.h>

extern "C" {
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
}

#include <cassert>
#include <new>

namespace equistream {

namespace {

constexpr int accurate = SWS_BICUBIC | SWS_ACCURATE_RND | SWS_BITEXACT | SWS_FULL_CHR_H_INT | SWS_FULL_CHR_H_INP;
constexpr AVPixelFormat ours = AV_PIX_FMT_YUV420P10LE;

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

void set(SwsContext& scaler, const char* option, int value) {
    [[maybe_unused]] const int code = av_opt_set_int(&scaler, option, value, 0);
    assert(code >= 0);
}

}  // namespace

bool is_pq(const AVFrame& frame) {
    return frame.color_trc == AVCOL_TRC_SMPTE2084 && frame.colorspace == AVCOL_SPC_BT2020_NCL && frame.width % 2 == 0 &&
           frame.height % 2 == 0 && sws_isSupportedInput(static_cast<AVPixelFormat>(frame.format)) > 0;
}

void PqScaler::prepare(const Format& format) {
    if (scaler_ && format == format_)
        return;
    scaler_.reset(sws_alloc_context());
    if (!scaler_)
        throw std::bad_alloc();
    for (const char* option : {"srcw", "dstw"})
        set(*scaler_, option, format.width);
    for (const char* option : {"srch", "dsth"})
        set(*scaler_, option, format.height);
    set(*scaler_, "src_format", format.pixel_format);
    set(*scaler_, "dst_format", ours);
    set(*scaler_, "sws_flags", accurate);
    const AVPixFmtDescriptor& lies = *av_pix_fmt_desc_get(static_cast<AVPixelFormat>(format.pixel_format));
    const ChromaPlace from = place_of(format.chroma_location), to;
    // Where chroma is whole it has no place of its own.
    if (lies.log2_chroma_w > 0)
        set(*scaler_, "src_h_chr_pos", from.x);
    if (lies.log2_chroma_h > 0)
        set(*scaler_, "src_v_chr_pos", from.y);
    set(*scaler_, "dst_h_chr_pos", to.x);
    set(*scaler_, "dst_v_chr_pos", to.y);
    if (sws_init_context(scaler_.get(), nullptr, nullptr) < 0)
        throw WorkError(std::string("no conversion of PQ from pixel format ") + lies.name);
    const int* matrix = sws_getCoefficients(SWS_CS_BT2020);
    sws_setColorspaceDetails(scaler_.get(), matrix, format.range == AVCOL_RANGE_JPEG, matrix, 0, 0, 1 << 16, 1 << 16);
    format_ = format;
}

av::Frame PqScaler::as_ours(const AVFrame& pq) {
    prepare({pq.width, pq.height, pq.format, pq.color_range, pq.chroma_location});
    av::Frame scaled = av::make_frame();
    scaled->format = ours;
    scaled->width = pq.width;
    scaled->height = pq.height;
    if (av_frame_get_buffer(scaled.get(), 0) < 0)
        throw std::bad_alloc();
    if (const int code = sws_scale_frame(scaler_.get(), scaled.get(), &pq); code < 0)
        throw WorkError("conversion of PQ: " + av::error_text(code));
    return scaled;
}

}  // namespace equistream
