#include "source.h"

#include <equistream/error.h>
#include <equistream/image.h>

#include <cerrno>
#include <filesystem>
#include <new>
#include <span>
#include <vector>

namespace equistream {

namespace {

/// Video in one file; playlists and the like could make a hostile file open others.
constexpr const char* accepted_formats =
    "mov,mp4,matroska,webm,mpegts,nut,h264,hevc,avi,flv,mpeg,mpegvideo,ivf,ogg,asf,m4v,mjpeg,mxf,yuv4mpegpipe,av1,obu";

/// Frees what avformat_find_stream_info wants, one dictionary a stream.
class StreamOptions {
public:
    explicit StreamOptions(const AVFormatContext& format) : entries_(format.nb_streams, nullptr) {
        for (AVDictionary*& entry : entries_)
            av_dict_set_int(&entry, "max_pixels", max_image_pixels, 0);
    }
    ~StreamOptions() {
        for (AVDictionary*& entry : entries_)
            av_dict_free(&entry);
    }
    StreamOptions(const StreamOptions&) = delete;
    StreamOptions& operator=(const StreamOptions&) = delete;
    AVDictionary** data() { return entries_.data(); }

private:
    std::vector<AVDictionary*> entries_;
};

/// libav asks while it waits; `interrupted` is a std::function<bool()>.
int answer_interrupt(void* interrupted) {
    return (*static_cast<const std::function<bool()>*>(interrupted))() ? 1 : 0;
}

constexpr int buffer_bytes = 1 << 16;

/// `read` is StreamReadOptions::read.
int read_bytes(void* read, std::uint8_t* bytes, int size) {
    try {  // nothing may be thrown through libav
        const auto& from = *static_cast<const std::function<std::size_t(std::span<std::uint8_t>)>*>(read);
        const std::size_t count = from({bytes, std::size_t(size)});
        return count == 0 ? AVERROR_EOF : int(count);
    } catch (const std::exception&) {
        return AVERROR(EIO);
    }
}

AVIOContext* make_io(const StreamReadOptions& options) {
    auto* buffer = static_cast<unsigned char*>(av_malloc(buffer_bytes));
    auto* read = const_cast<std::function<std::size_t(std::span<std::uint8_t>)>*>(&options.read);
    AVIOContext* io =
        buffer ? avio_alloc_context(buffer, buffer_bytes, 0, read, &read_bytes, nullptr, nullptr) : nullptr;
    if (io == nullptr) {
        av_free(buffer);
        throw std::bad_alloc();
    }
    return io;
}

}  // namespace

Source::Source(const std::string& name, const StreamReadOptions& read_options) {
    av::silence_log();
    const bool url = av::is_url(name);
    if (!url && !std::filesystem::exists(name))
        throw InputError(name + ": no such file");
    if (!url && std::filesystem::is_directory(name))
        throw InputError(expected_found(name, "a video file", "a folder"));
    av::Options options;
    options.set("format_whitelist", accepted_formats);
    options.set("fflags", "ignidx");  // looking ahead for an index makes a cut mp4 unreadable
    if (!url)
        options.set("protocol_whitelist", "file");
    AVFormatContext* opened = avformat_alloc_context();
    if (opened == nullptr)
        throw std::bad_alloc();
    format_.reset(opened);
    if (read_options.interrupted)
        opened->interrupt_callback = {answer_interrupt, const_cast<std::function<bool()>*>(&read_options.interrupted)};
    if (read_options.read) {
        io_.reset(make_io(read_options));
        opened->pb = io_.get();
    }
    format_.release();  // which is freed where opening fails
    const int code = avformat_open_input(&opened, (url ? name : "file:" + name).c_str(), nullptr, options.taken());
    if (code == AVERROR(EINVAL) && name.starts_with("tcp://"))
        throw InputError(expected_found(name, "tcp://HOST:PORT with a port of 1 to 65535", "another address"));
    // What libavformat says of a format that is not among ours.
    if (code == AVERROR(EINVAL) && !url)
        throw InputError(expected_found(name, "a video in MP4, Matroska, MPEG-TS or another container of videos",
                                        "a picture, or another kind of file"));
    if (code < 0)
        throw InputError(expected_found(name, "a video", av::error_text(code)));
    format_.reset(opened);
    StreamOptions stream_options(*format_);
    avformat_find_stream_info(format_.get(), stream_options.data());
}

}  // namespace equistream
