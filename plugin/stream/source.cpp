#include "source.h"

#include <equistream/error.h>
#include <equistream/file_kind.h>
#include <equistream/formatted.h>
#include <equistream/image.h>

#include <cerrno>
#include <filesystem>
#include <new>
#include <utility>
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

constexpr int buffer_bytes = 1 << 16;

/// A pipe is filled by whoever was started for it, at any pace.
bool is_server(const std::string& name) {
    return av::is_url(name) && !name.starts_with("pipe:");
}

}  // namespace

/// libav asks while it waits.
int Source::answer_interrupt(void* self) {
    return static_cast<Source*>(self)->is_to_give_up() ? 1 : 0;
}

bool Source::is_to_give_up() {
    if (options_.interrupted && options_.interrupted())
        return true;
    if (!is_watched_)
        return false;
    const std::int64_t bytes = opening_->pb == nullptr ? -1 : opening_->pb->bytes_read;
    if (std::exchange(bytes_, bytes) != bytes)
        begin_waiting();
    const double limit_s = bytes < 0 ? patience_.connect_s : bytes == 0 ? patience_.first_bytes_s : patience_.silence_s;
    if (seconds_since(waiting_since_) <= limit_s)
        return false;
    problem_ =
        formatted(bytes < 0 ? "the server did not answer for %g s" : "the server sent nothing for %g s", limit_s);
    return true;
}

int Source::read_bytes(void* self, std::uint8_t* bytes, int size) {
    auto& source = *static_cast<Source*>(self);
    try {  // nothing may be thrown through libav
        const std::size_t count = source.options_.read({bytes, std::size_t(size)});
        return count == 0 ? AVERROR_EOF : int(count);
    } catch (const std::exception& error) {
        source.problem_ = error.what();
        return AVERROR(EIO);
    }
}

void Source::make_io() {
    auto* buffer = static_cast<unsigned char*>(av_malloc(buffer_bytes));
    io_.reset(buffer ? avio_alloc_context(buffer, buffer_bytes, 0, this, &read_bytes, nullptr, nullptr) : nullptr);
    if (io_ == nullptr) {
        av_free(buffer);
        throw std::bad_alloc();
    }
}

Source::Source(const std::string& name, const StreamReadOptions& options, const Patience& patience)
    : options_(options), patience_(patience), is_watched_(is_server(name) && !options.read) {
    av::silence_log();
    const bool url = av::is_url(name);
    if (!url && !std::filesystem::exists(name))
        throw InputError(name + ": no such file");
    if (!url && std::filesystem::is_directory(name))
        throw InputError(expected_found(name, "a video file", "a folder"));
    open(name);
}

void Source::open(const std::string& name) {
    const bool url = av::is_url(name);
    av::Options options;
    options.set("format_whitelist", accepted_formats);
    options.set("fflags", "ignidx");  // looking ahead for an index makes a cut mp4 unreadable
    if (!url)
        options.set("protocol_whitelist", "file");
    AVFormatContext* opened = avformat_alloc_context();
    if (opened == nullptr)
        throw std::bad_alloc();
    format_.reset(opened);
    opening_ = opened;
    opened->interrupt_callback = {answer_interrupt, this};
    if (options_.read) {
        make_io();
        opened->pb = io_.get();
    }
    begin_waiting();
    format_.release();  // which is freed where opening fails
    const int code = avformat_open_input(&opened, (url ? name : "file:" + name).c_str(), nullptr, options.taken());
    if (code < 0 && !problem_.empty())
        throw WorkError(name + ": " + problem_);
    if (code == AVERROR(EINVAL) && name.starts_with("tcp://"))
        throw InputError(expected_found(name, "tcp://HOST:PORT with a port of 1 to 65535", "another address"));
    // What libavformat says of a format that is not among ours.
    if (code == AVERROR(EINVAL) && !url)
        throw InputError(expected_found(name, "a video in MP4, Matroska, MPEG-TS or another container of videos",
                                        found_kind(name, "a picture, or another kind of file")));
    if (code < 0)
        throw InputError(expected_found(
            name, "a video",
            found_kind(name, (url ? "none" : "a file of another kind") + (" (libav: " + av::error_text(code) + ")"))));
    format_.reset(opened);
    StreamOptions stream_options(*format_);
    begin_waiting();
    avformat_find_stream_info(format_.get(), stream_options.data());
}

}  // namespace equistream
