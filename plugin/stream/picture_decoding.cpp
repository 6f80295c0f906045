#include "picture_decoding.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <utility>

extern "C" {
#include <libavutil/hwcontext.h>
#include <libavutil/imgutils.h>
}

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

constexpr std::size_t alignment = 64;
/// Behind each plane, as libavcodec's own pools have it: vectors read and write past the end.
constexpr std::size_t max_overrun = 16 + alignment - 1;

using Lines = std::array<int, 4>;

struct PictureLayout {
    Lines linesize{};
    std::array<std::size_t, 4> offset{};
    std::size_t bytes = 0;
};

/// Lines a multiple of what each plane asks for, in the proportions that the format has.
std::optional<Lines> lines_of(AVPixelFormat format, int width, const int* line_alignment) {
    for (Lines lines{};; width += width & ~(width - 1)) {
        if (av_image_fill_linesizes(lines.data(), format, width) < 0)
            return std::nullopt;
        bool fits = true;
        for (std::size_t i = 0; i < lines.size(); ++i)
            fits = fits && lines[i] % std::max(1, line_alignment[i]) == 0;
        if (fits)
            return lines;
    }
}

std::optional<PictureLayout> layout_of(AVPixelFormat format, int width, int height, const int* line_alignment) {
    const std::optional<Lines> lines = lines_of(format, width, line_alignment);
    if (!lines)
        return std::nullopt;
    PictureLayout layout{.linesize = *lines};
    std::array<std::ptrdiff_t, 4> strides{};
    std::ranges::copy(*lines, strides.begin());
    std::array<std::size_t, 4> sizes{};
    if (av_image_fill_plane_sizes(sizes.data(), format, height, strides.data()) < 0)
        return std::nullopt;
    for (std::size_t i = 0; i < sizes.size() && sizes[i] > 0; ++i) {
        layout.offset[i] = layout.bytes;
        layout.bytes += (sizes[i] + max_overrun + alignment - 1) / alignment * alignment;
    }
    return layout;
}

void release(void* owner, std::uint8_t*) {
    delete static_cast<std::shared_ptr<std::uint8_t>*>(owner);
}

/// False where there is no memory; the frame is as it was then.
bool put_into(PictureMemory& memory, const PictureLayout& layout, AVFrame& frame) {
    auto owner = std::make_unique<std::shared_ptr<std::uint8_t>>(memory.take(layout.bytes));
    std::uint8_t* const bytes = owner->get();
    if (bytes == nullptr)
        return false;
    frame.buf[0] = av_buffer_create(bytes, layout.bytes, release, owner.get(), 0);
    if (frame.buf[0] == nullptr)
        return false;
    static_cast<void>(owner.release());
    for (std::size_t i = 0; i < layout.linesize.size() && layout.linesize[i] > 0; ++i) {
        frame.data[i] = bytes + layout.offset[i];
        frame.linesize[i] = layout.linesize[i];
    }
    frame.extended_data = frame.data;
    return true;
}

/// Those that are shown as they lie.
bool is_shown_as_it_lies(int format) {
    return format == AV_PIX_FMT_YUV420P || format == AV_PIX_FMT_YUV420P10;
}

int get_buffer(AVCodecContext* codec, AVFrame* frame, int flags) {
    PictureMemory* const memory = static_cast<const DecoderCallbacks*>(codec->opaque)->memory.get();
    if (memory != nullptr && (codec->codec->capabilities & AV_CODEC_CAP_DR1) != 0 &&
        is_shown_as_it_lies(frame->format)) {
        int width = frame->width, height = frame->height;
        std::array<int, AV_NUM_DATA_POINTERS> line_alignment{};
        avcodec_align_dimensions2(codec, &width, &height, line_alignment.data());
        const auto layout = layout_of(static_cast<AVPixelFormat>(frame->format), width, height, line_alignment.data());
        if (layout && put_into(*memory, *layout, *frame))
            return 0;
    }
    return avcodec_default_get_buffer2(codec, frame, flags);
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

void render_into_memory(AVCodecContext& codec) {
    codec.get_buffer2 = get_buffer;
#if LIBAVCODEC_VERSION_MAJOR < 60
    // Else threads of a decoder wait for the one that asked for a picture.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
    codec.thread_safe_callbacks = 1;
#pragma GCC diagnostic pop
#endif
}

av::Frame make_frame_in(PictureMemory* memory, AVPixelFormat format, int width, int height) {
    av::Frame frame = av::make_frame();
    frame->format = format;
    frame->width = width;
    frame->height = height;
    constexpr std::array line_alignment = {int{alignment}, int{alignment}, int{alignment}, int{alignment}};
    if (memory != nullptr && is_shown_as_it_lies(format))
        if (const auto layout = layout_of(format, width, height, line_alignment.data());
            layout && put_into(*memory, *layout, *frame))
            return frame;
    return av_frame_get_buffer(frame.get(), 0) < 0 ? nullptr : std::move(frame);
}

}  // namespace equistream
