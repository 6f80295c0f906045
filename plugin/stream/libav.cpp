#include "libav.h"

#include <equistream/error.h>

#include <mutex>
#include <new>

namespace equistream::av {

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

void Options::require_all_taken(const std::string& who) const {
    if (const AVDictionaryEntry* entry = av_dict_get(entries_, "", nullptr, AV_DICT_IGNORE_SUFFIX))
        throw InputError(who + " does not know the option " + entry->key);
}

std::string error_text(int code) {
    char text[AV_ERROR_MAX_STRING_SIZE] = {};
    av_strerror(code, text, sizeof text);
    return text;
}

void silence_log() {
    static std::once_flag once;
    std::call_once(once, [] {
        av_log_set_level(AV_LOG_QUIET);
        avformat_network_init();
    });
}

bool is_url(const std::string& target) {
    return target.find("://") != std::string::npos || target.starts_with("pipe:");
}

}  // namespace equistream::av
