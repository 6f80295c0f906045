#include "source.h"

#include <equistream/error.h>
#include <equistream/image.h>

#include <filesystem>
#include <new>
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

}  // namespace

av::Demuxer open_source(const std::string& source, const std::function<bool()>& interrupted) {
    const bool url = av::is_url(source);
    if (!url && !std::filesystem::exists(source))
        throw InputError(source + ": no such file");
    if (!url && std::filesystem::is_directory(source))
        throw InputError(expected_found(source, "a video file", "a folder"));
    av::Options options;
    options.set("format_whitelist", accepted_formats);
    options.set("fflags", "ignidx");  // looking ahead for an index makes a cut mp4 unreadable
    if (!url)
        options.set("protocol_whitelist", "file");
    AVFormatContext* opened = avformat_alloc_context();
    if (opened == nullptr)
        throw std::bad_alloc();
    if (interrupted)
        opened->interrupt_callback = {answer_interrupt, const_cast<std::function<bool()>*>(&interrupted)};
    const int code = avformat_open_input(&opened, (url ? source : "file:" + source).c_str(), nullptr, options.taken());
    if (code < 0)
        throw InputError(expected_found(source, "a video", av::error_text(code)));
    av::Demuxer format(opened);
    StreamOptions stream_options(*format);
    avformat_find_stream_info(format.get(), stream_options.data());
    return format;
}

}  // namespace equistream
