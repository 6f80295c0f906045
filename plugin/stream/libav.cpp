#include "libav.h"

#include "pipe.h"

#include <equistream/error.h>
#include <equistream/stream.h>

#include <cstring>
#include <mutex>
#include <new>

namespace equistream::av {

namespace {

constexpr int max_failures_in_a_row = 1000;

/// Looked at as the number it is stored as: an enum may not even be read while it holds something else.
template <typename Enum>
void keep_known(Enum& value, Enum count, Enum unspecified) {
    static_assert(sizeof(Enum) == sizeof(int));
    int stored = 0;
    std::memcpy(&stored, &value, sizeof stored);
    if (stored < 0 || stored >= static_cast<int>(count))
        value = unspecified;
}

}  // namespace

Frame make_frame() {
    Frame frame(av_frame_alloc());
    if (!frame)
        throw std::bad_alloc();
    return frame;
}

Packet make_packet() {
    Packet packet(av_packet_alloc());
    if (!packet)
        throw std::bad_alloc();
    return packet;
}

Frame make_frame(AVPixelFormat format, int width, int height) {
    Frame frame = make_frame();
    frame->format = format;
    frame->width = width;
    frame->height = height;
    if (av_frame_get_buffer(frame.get(), 0) < 0)
        throw std::bad_alloc();
    return frame;
}

int read_packet(AVFormatContext& format, AVPacket& packet) {
    int code = AVERROR_INVALIDDATA;
    for (int failures = 0; code == AVERROR_INVALIDDATA && failures < max_failures_in_a_row; ++failures)
        code = av_read_frame(&format, &packet);
    return code;
}

void Options::require_all_taken(const std::string& who) const {
    if (const AVDictionaryEntry* entry = av_dict_get(entries_, "", nullptr, AV_DICT_IGNORE_SUFFIX))
        throw InputError(who + " does not know the option " + entry->key);
}

void forget_unknown_colours(AVCodecParameters& parameters) {
    keep_known(parameters.color_range, AVCOL_RANGE_NB, AVCOL_RANGE_UNSPECIFIED);
    keep_known(parameters.color_primaries, AVCOL_PRI_NB, AVCOL_PRI_UNSPECIFIED);
    keep_known(parameters.color_trc, AVCOL_TRC_NB, AVCOL_TRC_UNSPECIFIED);
    keep_known(parameters.color_space, AVCOL_SPC_NB, AVCOL_SPC_UNSPECIFIED);
    keep_known(parameters.chroma_location, AVCHROMA_LOC_NB, AVCHROMA_LOC_UNSPECIFIED);
}

void forget_unknown_colours(AVFrame& frame) {
    keep_known(frame.color_range, AVCOL_RANGE_NB, AVCOL_RANGE_UNSPECIFIED);
    keep_known(frame.color_primaries, AVCOL_PRI_NB, AVCOL_PRI_UNSPECIFIED);
    keep_known(frame.color_trc, AVCOL_TRC_NB, AVCOL_TRC_UNSPECIFIED);
    keep_known(frame.colorspace, AVCOL_SPC_NB, AVCOL_SPC_UNSPECIFIED);
    keep_known(frame.chroma_location, AVCHROMA_LOC_NB, AVCHROMA_LOC_UNSPECIFIED);
}

std::string error_text(int code) {
    char text[AV_ERROR_MAX_STRING_SIZE] = {};
    av_strerror(code, text, sizeof text);
    return text;
}

void silence_log() {
    static std::once_flag once;
    std::call_once(once, [] {
        if (av_log_get_level() == AV_LOG_INFO)
            av_log_set_level(AV_LOG_QUIET);
        avformat_network_init();
    });
}

}  // namespace equistream::av

namespace equistream {

bool is_url(const std::string& name) {
    return name.find("://") != std::string::npos || name.starts_with(pipe_scheme);
}

}  // namespace equistream
