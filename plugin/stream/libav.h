#pragma once
/// RAII for libav's handles, and its errors as text.
extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libswscale/swscale.h>
}

#include <memory>
#include <string>

namespace equistream::av {

struct Delete {
    void operator()(AVFrame* frame) const { av_frame_free(&frame); }
    void operator()(AVPacket* packet) const { av_packet_free(&packet); }
    void operator()(AVCodecContext* codec) const { avcodec_free_context(&codec); }
    void operator()(SwsContext* scaler) const { sws_freeContext(scaler); }
};
struct CloseDemuxer {
    void operator()(AVFormatContext* input) const { avformat_close_input(&input); }
};
struct FreeIo {
    void operator()(AVIOContext* io) const {
        av_freep(&io->buffer);
        avio_context_free(&io);
    }
};
struct FreeMuxer {
    void operator()(AVFormatContext* output) const { avformat_free_context(output); }
};

using Frame = std::unique_ptr<AVFrame, Delete>;
using Packet = std::unique_ptr<AVPacket, Delete>;
using Codec = std::unique_ptr<AVCodecContext, Delete>;
using Scaler = std::unique_ptr<SwsContext, Delete>;
using Demuxer = std::unique_ptr<AVFormatContext, CloseDemuxer>;
using Io = std::unique_ptr<AVIOContext, FreeIo>;
using Muxer = std::unique_ptr<AVFormatContext, FreeMuxer>;

/// Allocate or throw std::bad_alloc.
Frame make_frame();
Packet make_packet();
/// With memory for a picture of this format and size.
Frame make_frame(AVPixelFormat format, int width, int height);

/// av_read_frame, past what cannot be read: in a cut mp4 the other track's samples may still be there behind one that
/// is not.
int read_packet(AVFormatContext& format, AVPacket& packet);

/// An AVDictionary that is freed; options that a libav call did not take stay in it.
class Options {
public:
    Options() = default;
    ~Options() { av_dict_free(&entries_); }
    Options(const Options&) = delete;
    Options& operator=(const Options&) = delete;

    void set(const char* key, const std::string& value) { av_dict_set(&entries_, key, value.c_str(), 0); }
    AVDictionary** taken() { return &entries_; }
    /// Throws InputError if an option was left over: `who` does not know it.
    void require_all_taken(const std::string& who) const;

private:
    AVDictionary* entries_ = nullptr;
};

/// Demuxers and decoders hand on what files say of colours: values without a name become "unspecified".
void forget_unknown_colours(AVCodecParameters& parameters);
void forget_unknown_colours(AVFrame& frame);

/// libav's sentence for an error code.
std::string error_text(int code);

/// libav and the encoders print what they think; whatever matters is thrown instead. The first call does it, for the
/// whole process. A log level that is not libav's default was chosen by a host, and stays.
void silence_log();

}  // namespace equistream::av
