#include "picture_converter.h"

#include "scaling.h"
#include "yuv420.h"

#include <equistream/error.h>

extern "C" {
#include <libavutil/pixdesc.h>
}

#include <algorithm>

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

av::Frame make_frame(AVPixelFormat format, int width, int height) {
    av::Frame yuv = av::make_frame();
    yuv->format = format;
    yuv->width = width;
    yuv->height = height;
    yuv->color_range = AVCOL_RANGE_MPEG;
    yuv->chroma_location = AVCHROMA_LOC_LEFT;
    if (av_frame_get_buffer(yuv.get(), 0) < 0)
        throw std::bad_alloc();
    return yuv;
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
    av::Frame yuv = make_frame(AV_PIX_FMT_YUV420P10LE, rgb.width, rgb.height);
    yuv->color_primaries = AVCOL_PRI_BT2020;
    yuv->color_trc = AVCOL_TRC_SMPTE2084;
    yuv->colorspace = AVCOL_SPC_BT2020_NCL;
    rgb_to_pq(rgb, planes_of<std::uint16_t>(*yuv));
    return yuv;
}

YuvView yuv420_planes_of(const AVFrame& frame) {
    return planes_of<const std::uint8_t>(frame);
}

av::Frame yuv_frame_of(ImageView<const std::uint8_t> rgb) {
    av::Frame yuv = make_frame(AV_PIX_FMT_YUV420P, rgb.width, rgb.height);
    yuv->color_primaries = AVCOL_PRI_BT709;
    yuv->color_trc = AVCOL_TRC_IEC61966_2_1;
    yuv->colorspace = AVCOL_SPC_BT709;
    rgb_to_yuv420(rgb, planes_of<std::uint8_t>(*yuv));
    return yuv;
}

void YuvToRgb::prepare(const Format& format) {
    if (scaler_ && format == format_)
        return;
    scaler_ = make_scaler(format.width, format.height, format.pixel_format, AV_PIX_FMT_RGB24);
    scaled_ = av::make_frame();
    scaled_->format = AV_PIX_FMT_RGB24;
    scaled_->width = format.width;
    scaled_->height = format.height;
    if (av_frame_get_buffer(scaled_.get(), 0) < 0)
        throw std::bad_alloc();
    if (sws_init_context(scaler_.get(), nullptr, nullptr) < 0)
        throw WorkError(std::string("no conversion to RGB from pixel format ") +
                        av_get_pix_fmt_name(static_cast<AVPixelFormat>(format.pixel_format)));
    sws_setColorspaceDetails(scaler_.get(), sws_getCoefficients(format.matrix), format.range == AVCOL_RANGE_JPEG,
                             sws_getCoefficients(SWS_CS_ITU709), 1, 0, 1 << 16, 1 << 16);
    format_ = format;
}

void YuvToRgb::scale(const AVFrame& yuv, ImageView<std::uint8_t> rgb) {
    prepare({yuv.width, yuv.height, yuv.format, matrix_of(yuv), yuv.color_range});
    // swscale touches bytes beyond the ends of rows: it gets a padded frame of libav's own.
    if (const int code = sws_scale_frame(scaler_.get(), scaled_.get(), &yuv); code < 0)
        throw WorkError("conversion to RGB: " + av::error_text(code));
    for (int y = 0; y < rgb.height; ++y)
        std::copy_n(scaled_->data[0] + static_cast<std::ptrdiff_t>(y) * scaled_->linesize[0], rgb.row_stride,
                    rgb.row(y));
}

ByteImage YuvToRgb::convert(const AVFrame& yuv) {
    ByteImage rgb(yuv.width, yuv.height, 3);
    if (is_our_yuv420(yuv))
        yuv420_to_rgb(yuv420_planes_of(yuv), rgb.view());
    else
        scale(yuv, rgb.view());
    return rgb;
}

}  // namespace equistream
