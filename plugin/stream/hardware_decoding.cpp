#include "hardware_decoding.h"

extern "C" {
#include <libavutil/hwcontext.h>
#include <libavutil/imgutils.h>
}

#include <cstdint>
#include <utility>

namespace equistream {

namespace {

/// libavcodec asks again without a format whose hardware then fails.
AVPixelFormat choose_format(AVCodecContext* codec, const AVPixelFormat* offered) {
    const AVPixelFormat wanted = static_cast<const DecoderCallbacks*>(codec->opaque)->hardware_format;
    for (const AVPixelFormat* format = offered; *format != AV_PIX_FMT_NONE; ++format)
        if (*format == wanted)
            return wanted;
    return avcodec_default_get_format(codec, offered);
}

}  // namespace

void HardwareDecoding::look_for(const AVCodecParameters& parameters) {
    const AVCodec* decoder = avcodec_find_decoder(parameters.codec_id);
    if (decoder == nullptr || parameters.format != AV_PIX_FMT_YUV420P)
        return;
    for (int i = 0; device_ == nullptr; ++i) {
        const AVCodecHWConfig* config = avcodec_get_hw_config(decoder, i);
        if (config == nullptr)
            return;
        // VDPAU's library complains on stderr where its drivers are missing.
        if (config->device_type == AV_HWDEVICE_TYPE_VDPAU)
            continue;
        if ((config->methods & AV_CODEC_HW_CONFIG_METHOD_HW_DEVICE_CTX) != 0 &&
            av_hwdevice_ctx_create(&device_, config->device_type, nullptr, nullptr, 0) >= 0) {
            type_ = config->device_type;
            format_ = config->pix_fmt;
        }
    }
}

void HardwareDecoding::offer_to(AVCodecContext& codec, DecoderCallbacks& callbacks) const {
    if (device_ == nullptr)
        return;
    codec.hw_device_ctx = av_buffer_ref(device_);
    callbacks.hardware_format = format_;
    codec.get_format = choose_format;
}

std::string_view HardwareDecoding::name_of(const AVFrame& frame) const {
    return device_ != nullptr && frame.format == format_ ? av_hwdevice_get_type_name(type_) : "software";
}

bool HardwareDecoding::fetch(av::Frame& frame, PictureMemory* memory) const {
    if (device_ == nullptr || frame->format != format_)
        return true;
    av::Frame fetched = av::make_frame();
    if (av_hwframe_transfer_data(fetched.get(), frame.get(), 0) < 0 ||
        av_frame_copy_props(fetched.get(), frame.get()) < 0)
        return false;
    frame = with_own_chroma_planes(std::move(fetched), memory);
    return frame != nullptr;
}

av::Frame with_own_chroma_planes(av::Frame frame, PictureMemory* memory) {
    if (frame->format != AV_PIX_FMT_NV12)
        return frame;
    av::Frame planar = make_frame_in(memory, AV_PIX_FMT_YUV420P, frame->width, frame->height);
    if (planar == nullptr || av_frame_copy_props(planar.get(), frame.get()) < 0)
        return nullptr;
    av_image_copy_plane(planar->data[0], planar->linesize[0], frame->data[0], frame->linesize[0], frame->width,
                        frame->height);
    for (int y = 0; y < (frame->height + 1) / 2; ++y) {
        const std::uint8_t* pair = frame->data[1] + std::ptrdiff_t{y} * frame->linesize[1];
        std::uint8_t* cb = planar->data[1] + std::ptrdiff_t{y} * planar->linesize[1];
        std::uint8_t* cr = planar->data[2] + std::ptrdiff_t{y} * planar->linesize[2];
        for (int x = 0; x < (frame->width + 1) / 2; ++x, pair += 2) {
            cb[x] = pair[0];
            cr[x] = pair[1];
        }
    }
    return planar;
}

}  // namespace equistream
