#include "direct_rendering.h"

extern "C" {
#include <libavutil/imgutils.h>
}

#include <algorithm>
#include <array>
#include <optional>

namespace equistream {

namespace {

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
