#include "probes.h"

#include <equistream/error.h>
#include <equistream/text.h>
#include <plugin/denoise/oidn.h>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavutil/hwcontext.h>
#include <libavutil/log.h>
#include <libavutil/opt.h>
}

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace equistream::doctor {

namespace {

struct FreeContext {
    void operator()(AVCodecContext* context) const { avcodec_free_context(&context); }
};

/// Libraries of encoders may be built for fewer bits than their headers know: so it is opened.
bool opens(const AVCodec* encoder, AVPixelFormat format) {
    const std::unique_ptr<AVCodecContext, FreeContext> context(avcodec_alloc_context3(encoder));
    if (!context)
        return false;
    context->width = context->height = 128;
    context->time_base = {1, 30};
    context->framerate = {30, 1};
    context->thread_count = 1;
    context->pix_fmt = format;
    av_opt_set(context->priv_data, "preset", "ultrafast", 0);
    av_opt_set(context->priv_data, "x265-params", "log-level=none:pools=none:frame-threads=1", 0);
    return avcodec_open2(context.get(), encoder, nullptr) == 0;
}

struct Coded {
    const char* codec;
    const char* encoder;
    AVCodecID id;
};
constexpr std::array coded = {Coded{"H.264", "libx264", AV_CODEC_ID_H264}, Coded{"H.265", "libx265", AV_CODEC_ID_HEVC}};

}  // namespace

Finding probe_video() {
    av_log_set_level(AV_LOG_QUIET);
    Finding finding;
    std::vector<std::string> lacks;
    for (const Coded& each : coded) {
        const AVCodec* encoder = avcodec_find_encoder_by_name(each.encoder);
        const bool bits8 = encoder != nullptr && opens(encoder, AV_PIX_FMT_YUV420P);
        const bool bits10 = encoder != nullptr && opens(encoder, AV_PIX_FMT_YUV420P10);
        const AVCodec* decoder = avcodec_find_decoder(each.id);
        finding.details[each.codec] = {
            {"encoder", encoder != nullptr ? each.encoder : ""},
            {"encodes_8_bits", bits8},
            {"encodes_10_bits", bits10},
            {"decoder", decoder != nullptr ? decoder->name : ""},
        };
        if (!bits8 || !bits10)
            lacks.push_back(std::string("encoding ") + each.codec + (bits8 ? " with 10 bits" : "") + " by " +
                            each.encoder);
        if (decoder == nullptr)
            lacks.push_back(std::string("decoding ") + each.codec);
    }
    const unsigned version = avcodec_version();
    const std::string library = formatted("libavcodec %u.%u.%u", AV_VERSION_MAJOR(version), AV_VERSION_MINOR(version),
                                          AV_VERSION_MICRO(version));
    finding.details["library"] = library;
    finding.get = "sudo apt-get install libavcodec" AV_STRINGIFY(LIBAVCODEC_VERSION_MAJOR);
    if (!lacks.empty()) {
        finding.found = library + " without " + in_a_sentence(lacks, " and ");
        return finding;
    }
    return Finding::ok("H.264 and H.265 are encoded (libx264, libx265) and decoded, with 8 and 10 bits: " + library,
                       finding.details);
}

Finding probe_hardware_decoding() {
    av_log_set_level(AV_LOG_QUIET);
    std::vector<std::string> devices;
    for (AVHWDeviceType type = AV_HWDEVICE_TYPE_NONE;
         (type = av_hwdevice_iterate_types(type)) != AV_HWDEVICE_TYPE_NONE;) {
        AVBufferRef* device = nullptr;
        if (av_hwdevice_ctx_create(&device, type, nullptr, nullptr, 0) >= 0)
            devices.emplace_back(av_hwdevice_get_type_name(type));
        av_buffer_unref(&device);
    }
    if (devices.empty())
        return {State::missing, "no hardware decoder opens: decoding runs on the CPU", "", {}};
    return Finding::ok("hardware decoders: " + in_a_sentence(devices, " and "), {{"devices", devices}});
}

Finding probe_denoiser() {
    const oidn::Device device(0);
    return Finding::ok(device.name(), {{"name", device.name()}});
}

}  // namespace equistream::doctor
