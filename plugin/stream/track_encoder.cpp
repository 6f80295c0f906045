#include "track_encoder.h"

#include <equistream/error.h>

extern "C" {
#include <libavutil/cpu.h>
}

#include <algorithm>
#include <cmath>

namespace equistream {

namespace {

constexpr const char* presets[] = {"ultrafast", "superfast", "veryfast", "faster",   "fast",
                                   "medium",    "slow",      "slower",   "veryslow", "placebo"};
constexpr int worst_crf = 51;
constexpr int most_threads = 64;

void check_whole_number(const char* what, int value, int low, int high) {
    if (value < low || value > high)
        throw InputError(
            expected_found(what, std::to_string(low) + " to " + std::to_string(high), std::to_string(value)));
}

void check_preset(const std::string& preset) {
    if (std::find(std::begin(presets), std::end(presets), preset) != std::end(presets))
        return;
    std::string accepted;
    for (const char* name : presets)
        accepted += (accepted.empty() ? "" : ", ") + std::string(name);
    throw InputError(expected_found("preset", "one of " + accepted, "\"" + preset + "\""));
}

void check_track(const TrackSettings& track) {
    const std::string size = std::to_string(track.width) + "x" + std::to_string(track.height);
    const std::string where = std::string(track_name(track.role)) + " track";
    // Both codecs' 4:2:0 needs even sides; libx265 needs a whole coding unit.
    if (track.width < min_track_side || track.height < min_track_side || track.width > max_image_side ||
        track.height > max_image_side)
        throw InputError(expected_found(
            where, "sides of " + std::to_string(min_track_side) + " to " + std::to_string(max_image_side) + " pixels",
            size));
    if (track.width % 2 != 0 || track.height % 2 != 0)
        throw InputError(expected_found(where, "an even width and height (4:2:0 video has no odd sizes)", size));
}

void set_colour_tags(AVCodecContext& codec) {
    codec.pix_fmt = AV_PIX_FMT_YUV420P;
    codec.color_range = AVCOL_RANGE_MPEG;
    codec.color_primaries = AVCOL_PRI_BT709;
    codec.color_trc = AVCOL_TRC_IEC61966_2_1;
    codec.colorspace = AVCOL_SPC_BT709;
    codec.chroma_sample_location = AVCHROMA_LOC_LEFT;
}

/// Fixed groups of pictures that can be entered at each key frame; frame data passed through.
void set_encoder_options(const StreamSettings& settings, av::Options& options) {
    options.set("preset", settings.preset);
    options.set("crf", std::to_string(settings.crf));
    options.set("udu_sei", "1");
    if (settings.codec == Codec::h264) {
        options.set("sc_threshold", "0");
        // libx264's AVX-512 macroblock tree reads memory that was never written: other bytes each time, and worse.
        if ((av_get_cpu_flags() & AV_CPU_FLAG_AVX512) != 0)
            options.set("x264-params", "asm=avx2");
        return;
    }
    options.set("x265-params", "log-level=none:frame-threads=" + std::to_string(std::min(settings.threads, 16)) +
                                   ":open-gop=0:scenecut=0:min-keyint=" + std::to_string(settings.gop));
}

av::Codec open_encoder(const StreamSettings& settings, const TrackSettings& track, bool global_header) {
    const char* name = settings.codec == Codec::h264 ? "libx264" : "libx265";
    const AVCodec* encoder = avcodec_find_encoder_by_name(name);
    if (!encoder)
        throw InputError(std::string(name) + ": this libavcodec was built without it");
    av::Codec codec(avcodec_alloc_context3(encoder));
    if (!codec)
        throw std::bad_alloc();
    codec->width = track.width;
    codec->height = track.height;
    codec->framerate = frame_rate_of(settings);
    codec->time_base = av_inv_q(codec->framerate);
    codec->sample_aspect_ratio = {1, 1};
    codec->gop_size = settings.gop;
    codec->thread_count = settings.threads;
    set_colour_tags(*codec);
    if (global_header)
        codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    av::Options options;
    set_encoder_options(settings, options);
    const int code = avcodec_open2(codec.get(), encoder, options.taken());
    if (code < 0)
        throw InputError(std::string(name) + " refused " + std::to_string(track.width) + "x" +
                         std::to_string(track.height) + ", preset " + settings.preset + ": " + av::error_text(code));
    options.require_all_taken(std::string(name) + " of this libavcodec");
    return codec;
}

}  // namespace

AVRational frame_rate_of(const StreamSettings& settings) {
    return av_d2q(settings.frames_per_second, 100000);
}

void check_stream_settings(const StreamSettings& settings) {
    check_whole_number("crf", settings.crf, 0, worst_crf);
    check_whole_number("gop", settings.gop, 1, 10000);
    check_whole_number("threads", settings.threads, 1, most_threads);
    check_preset(settings.preset);
    if (!(settings.frames_per_second >= 0.01 && settings.frames_per_second <= 1000))
        throw InputError(
            expected_found("frames per second", "0.01 to 1000", std::to_string(settings.frames_per_second)));
    if (settings.tracks.empty())
        throw InputError(expected_found("stream", "at least one track", "none"));
    for (const TrackSettings& track : settings.tracks) {
        check_track(track);
        if (std::count_if(settings.tracks.begin(), settings.tracks.end(),
                          [&](const TrackSettings& other) { return other.role == track.role; }) > 1)
            throw InputError(expected_found("stream", "each track once", std::string("two ") + track_name(track.role)));
    }
}

TrackEncoder::TrackEncoder(const StreamSettings& settings, const TrackSettings& track, bool global_header)
    : track_(track), codec_(open_encoder(settings, track, global_header)) {}

av::Frame TrackEncoder::convert(ImageView<const std::uint8_t> rgb) const {
    if (rgb.width != track_.width || rgb.height != track_.height || rgb.channels != 3)
        throw WorkError(expected_found(std::string(track_name(track_.role)) + " track",
                                       std::to_string(track_.width) + "x" + std::to_string(track_.height) + " RGB",
                                       std::to_string(rgb.width) + "x" + std::to_string(rgb.height) + " with " +
                                           std::to_string(rgb.channels) + " channels"));
    return yuv_frame_of(rgb);
}

void TrackEncoder::encode(av::Frame picture, std::int64_t pts, std::span<const std::uint8_t> payload,
                          const std::function<void(AVPacket&)>& emit) {
    picture->pts = pts;
    AVFrameSideData* data = av_frame_new_side_data(picture.get(), AV_FRAME_DATA_SEI_UNREGISTERED, payload.size());
    if (!data)
        throw std::bad_alloc();
    std::copy(payload.begin(), payload.end(), data->data);
    send(picture.get(), emit);
}

void TrackEncoder::drain(const std::function<void(AVPacket&)>& emit) {
    send(nullptr, emit);
}

void TrackEncoder::send(const AVFrame* picture, const std::function<void(AVPacket&)>& emit) {
    int code = avcodec_send_frame(codec_.get(), picture);
    while (code >= 0) {
        code = avcodec_receive_packet(codec_.get(), packet_.get());
        if (code >= 0)
            emit(*packet_);
        av_packet_unref(packet_.get());
    }
    if (code != AVERROR(EAGAIN) && code != AVERROR_EOF)
        throw WorkError(std::string(codec_->codec->name) + ": " + av::error_text(code));
}

}  // namespace equistream
