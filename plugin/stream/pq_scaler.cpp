#include "pq_scaler.h"

#include "scaling.h"

#include <equistream/error.h>

extern "C" {
#include <libavutil/pixdesc.h>
}

#include <new>

namespace equistream {

namespace {

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

}  // namespace

bool is_pq(const AVFrame& frame) {
    return frame.color_trc == AVCOL_TRC_SMPTE2084 && frame.colorspace == AVCOL_SPC_BT2020_NCL && frame.width % 2 == 0 &&
           frame.height % 2 == 0 && sws_isSupportedInput(static_cast<AVPixelFormat>(frame.format)) > 0;
}

void PqScaler::prepare(const Format& format) {
    if (scaler_ && format == format_)
        return;
    scaler_ = make_scaler(format.width, format.height, format.pixel_format, ours);
    const AVPixFmtDescriptor& lies = *av_pix_fmt_desc_get(static_cast<AVPixelFormat>(format.pixel_format));
    const ChromaPlace from = place_of(format.chroma_location), to;
    // Where chroma is whole it has no place of its own.
    if (lies.log2_chroma_w > 0)
        set_scaling(*scaler_, "src_h_chr_pos", from.x);
    if (lies.log2_chroma_h > 0)
        set_scaling(*scaler_, "src_v_chr_pos", from.y);
    set_scaling(*scaler_, "dst_h_chr_pos", to.x);
    set_scaling(*scaler_, "dst_v_chr_pos", to.y);
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
