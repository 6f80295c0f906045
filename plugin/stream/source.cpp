#include "source.h"

#include "matroska_file.h"

#include <equistream/error.h>
#include <equistream/file_kind.h>
#include <equistream/image.h>
#include <equistream/text.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <filesystem>
#include <limits>
#include <new>
#include <string_view>
#include <utility>
#include <vector>

namespace equistream {

namespace {

/// Video in one file; playlists and the like could make a hostile file open others.
constexpr const char* accepted_formats =
    "mov,mp4,matroska,webm,mpegts,nut,h264,hevc,avi,flv,mpeg,mpegvideo,ivf,ogg,asf,m4v,mxf,yuv4mpegpipe,av1,obu";

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
constexpr std::int64_t longest_analysis_us = 100'000;

/// A pipe is filled by whoever was started for it, at any pace.
bool is_server(const std::string& name) {
    return is_url(name) && !is_pipe(name);
}

bool says_frame_rates(const AVFormatContext& format) {
    return std::ranges::all_of(std::span(format.streams, format.nb_streams),
                               [](const AVStream* stream) { return stream->avg_frame_rate.num > 0; });
}

/// Containers round their times, some to milliseconds.
constexpr double same_time_s = 0.002;
/// Tracks are interleaved only roughly: by a group of pictures of each where an mp4 is in fragments.
constexpr double furthest_apart_s = 10;
/// An index may know of places that are no key frames: then one from so long before is looked for.
constexpr std::array<double, 3> earlier_s = {0, 2, 10};

double start_s(const AVStream& stream) {
    return stream.start_time == AV_NOPTS_VALUE ? 0 : double(stream.start_time) * av_q2d(stream.time_base);
}

/// What the search knows of one stream.
struct Found {
    int stream = 0;
    double extrapolation_s = 0;  ///< its times are by so much, of one moment
    bool has_key = false;        ///< packets from a key frame on are kept
    bool is_past = false;        ///< no key frame that is shown in time can follow
};

class Search {
public:
    /// Tracks begin with one moment. An mp4 in fragments has no times below zero: there a track whose pictures are
    /// coded in another order than they are shown in begins later.
    Search(AVFormatContext& format, std::span<const int> streams, double time_s)
        : format_(format), latest_s_(time_s + same_time_s) {
        const double first_s = start_s(*format.streams[streams.front()]);
        for (const int stream : streams)
            found_.push_back({stream, start_s(*format.streams[stream]) - first_s, false, false});
    }

    /// From where the demuxer stands. False where it stands behind what is looked for.
    bool run() {
        packets_.clear();
        for (Found& one : found_)
            one.has_key = one.is_past = false;
        while (!is_done()) {
            av::Packet packet = av::make_packet();
            if (av::read_packet(format_, *packet) < 0)
                break;
            const auto of = std::ranges::find(found_, packet->stream_index, &Found::stream);
            if (of != found_.end() && !take(std::move(packet), *of))
                return false;
        }
        return found_.front().has_key;
    }

    bool all_have_keys() const { return std::ranges::all_of(found_, &Found::has_key); }
    std::deque<av::Packet> packets() { return std::move(packets_); }

private:
    double seconds(const Found& of, std::int64_t timestamp) const {
        return double(timestamp) * av_q2d(format_.streams[of.stream]->time_base) - of.extrapolation_s;
    }

    bool take(av::Packet packet, Found& of) {
        if (packet->pts == AV_NOPTS_VALUE)
            return false;
        const double decoded_s = seconds(of, packet->dts == AV_NOPTS_VALUE ? packet->pts : packet->dts);
        of.is_past = of.is_past || decoded_s > latest_s_;
        if (of.stream == found_.front().stream)
            main_s_ = decoded_s;
        if ((packet->flags & AV_PKT_FLAG_KEY) != 0 && seconds(of, packet->pts) <= latest_s_) {
            std::erase_if(packets_, [&](const av::Packet& earlier) { return earlier->stream_index == of.stream; });
            of.has_key = true;
        }
        if (of.has_key)
            packets_.push_back(std::move(packet));
        return of.has_key || !of.is_past || of.stream != found_.front().stream;
    }

    bool is_done() const {
        return std::ranges::all_of(found_, &Found::is_past) ||
               (found_.front().is_past && all_have_keys() && main_s_ > latest_s_ + furthest_apart_s);
    }

    AVFormatContext& format_;
    double latest_s_;
    double main_s_ = std::numeric_limits<double>::lowest();
    std::vector<Found> found_;
    std::deque<av::Packet> packets_;
};

bool go_to(AVFormatContext& format, int stream, double time_s) {
    const std::int64_t latest = std::llround(time_s / av_q2d(format.streams[stream]->time_base));
    return avformat_seek_file(&format, stream, std::numeric_limits<std::int64_t>::min(), latest, latest, 0) >= 0;
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
        if (source.pipe_)
            return source.pipe_->read({bytes, std::size_t(size)}, [&] { return source.is_to_give_up(); });
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

Source::Source(const std::string& name, const StreamReadOptions& options, const Patience& patience, bool is_copied)
    : options_(options), patience_(patience), is_watched_(is_server(name) && !options.read), is_copied_(is_copied) {
    av::silence_log();
    if (!is_url(name)) {
        const std::filesystem::file_type type = type_of(name, "a video file");
        if (type == std::filesystem::file_type::not_found)
            throw InputError(name + ": no such file");
        if (type == std::filesystem::file_type::directory)
            throw InputError(expected_found(name, "a video file", "a folder"));
    }
    open(name);
}

void Source::open(const std::string& name) {
    const bool url = is_url(name);
    av::Options options;
    options.set("format_whitelist", accepted_formats);
    // A Matroska file says where its index is. In an MP4 libav would look for it through all fragments, each time that
    // it is opened, and refuse one of which a single header is damaged or cut.
    if (url || !is_matroska(name))
        options.set("fflags", "ignidx");
    if (!url)
        options.set("protocol_whitelist", "file");
    AVFormatContext* opened = avformat_alloc_context();
    if (opened == nullptr)
        throw std::bad_alloc();
    format_.reset(opened);
    opening_ = opened;
    opened->interrupt_callback = {answer_interrupt, this};
    if (!options_.read)
        pipe_ = Pipe::open(name);
    if (options_.read || pipe_) {
        make_io();
        opened->pb = io_.get();
    }
    begin_waiting();
    format_.release();  // which is freed where opening fails
    const int code = avformat_open_input(&opened, (url ? name : "file:" + name).c_str(), nullptr, options.taken());
    if (code < 0 && !problem_.empty())
        throw WorkError(name + ": " + problem_);
    // What libavformat says of a format that is not among ours.
    if (code == AVERROR(EINVAL) && !url)
        throw InputError(expected_found(name, "a video in MP4, Matroska, MPEG-TS or another container of videos",
                                        found_kind(name, "a picture, or another kind of file")));
    if (code < 0)
        throw InputError(expected_found(
            name, "a video",
            found_kind(name, (url ? "none" : "a file of another kind") + (" (libav: " + av::error_text(code) + ")"))));
    format_.reset(opened);
    // The header says what tracks are. Of a server's tiles few come, and libav would wait for the others.
    if (url && has_tiles(*format_))
        format_->max_analyze_duration = longest_analysis_us;
    // Nor does libav need times of decoding, for which it reads eight pictures of each track: seconds of a slow server.
    if ((url || is_copied_) && says_frame_rates(*format_))
        format_->max_ts_probe = 0;
    StreamOptions stream_options(*format_);
    begin_waiting();
    avformat_find_stream_info(format_.get(), stream_options.data());
}

bool has_tiles(const AVFormatContext& format) {
    int windows = 0;
    for (unsigned i = 0; i < format.nb_streams; ++i)
        for (const char* key : {"title", "handler_name"})
            if (const AVDictionaryEntry* name = av_dict_get(format.streams[i]->metadata, key, nullptr, 0)) {
                windows += std::string_view(name->value) == track_name(TrackRole::window) ? 1 : 0;
                break;
            }
    return windows > 1;
}

std::optional<std::deque<av::Packet>> find_packets(AVFormatContext& format, std::span<const int> streams,
                                                   double time_s) {
    if (streams.empty())
        return std::nullopt;
    Search search(format, streams, time_s);
    // Encoders hold back different numbers of pictures: another track's key frame may lie before the first one's of the
    // same time.
    for (const double before_s : earlier_s)
        for (const int stream : streams)
            if (go_to(format, stream, time_s - before_s) && search.run() && search.all_have_keys())
                return search.packets();
    if (go_to(format, streams.front(), start_s(*format.streams[streams.front()])) && search.run())
        return search.packets();
    return std::nullopt;
}

}  // namespace equistream
