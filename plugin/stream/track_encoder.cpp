#include "track_encoder.h"

#include <equistream/error.h>
#include <equistream/text.h>

extern "C" {
#include <libavutil/cpu.h>
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
}

#include <algorithm>
#include <cmath>
#include <utility>

namespace equistream {

namespace {

constexpr const char* presets[] = {"ultrafast", "superfast", "veryfast", "faster",   "fast",
                                   "medium",    "slow",      "slower",   "veryslow", "placebo"};
constexpr int max_threads = 64;
/// Of live streams, whose groups end where they are asked to.
constexpr int endless_group = 1 << 24;

void check_whole_number(const std::string& what, int value, int low, int high) {
    if (value < low || value > high)
        throw InputError(
            expected_found(what, std::to_string(low) + " to " + std::to_string(high), std::to_string(value)));
}

void check_preset(const std::string& what, const std::string& preset) {
    if (std::find(std::begin(presets), std::end(presets), preset) != std::end(presets))
        return;
    throw InputError(expected_found(what, "one of " + in_a_sentence(presets, ", "), "\"" + preset + "\""));
}

void check_track(const TrackSettings& track) {
    const std::string size = size_text(track.width, track.height);
    const std::string where = std::string(track_name(track.role)) + " track";
    // Both codecs' 4:2:0 needs even sides; libx265 needs a whole coding unit.
    if (track.width < min_track_side || track.height < min_track_side || track.width > max_image_side ||
        track.height > max_image_side)
        throw InputError(expected_found(
            where, "sides of " + std::to_string(min_track_side) + " to " + std::to_string(max_image_side) + " pixels",
            size));
    if (track.width % 2 != 0 || track.height % 2 != 0)
        throw InputError(expected_found(where, "an even width and height (4:2:0 video has no odd sizes)", size));
    if (is_depth(track.role) != track.depth_code.has_value())
        throw InputError(expected_found(where, is_depth(track.role) ? "a depth code" : "no depth code",
                                        is_depth(track.role) ? "none" : depth_code_name(*track.depth_code)));
    if (track.halved && !may_be_halved(track.role))
        throw InputError(
            expected_found(where, "full resolution (only the depth of main and window may be halved)", "half"));
    if (track.halved && (track.width % 4 != 0 || track.height % 4 != 0 || track.coded_width() < min_track_side ||
                         track.coded_height() < min_track_side))
        throw InputError(expected_found(where,
                                        "sides of at least " + std::to_string(2 * min_track_side) +
                                            " pixels, in multiples of 4, to be halved",
                                        size));
    if (track.crf && !(*track.crf >= 0 && *track.crf <= worst_crf))
        throw InputError(expected_found(where, "crf of 0 to " + std::to_string(worst_crf), std::to_string(*track.crf)));
}

void set_colour_tags(AVCodecContext& codec, Transfer transfer, const DepthCode* depth) {
    if (depth == nullptr) {
        codec.pix_fmt = transfer == Transfer::pq ? our_pq : AV_PIX_FMT_YUV420P;
        codec.chroma_sample_location = AVCHROMA_LOC_LEFT;
        return tag_colour(codec, transfer);
    }
    codec.pix_fmt = pixel_format_of(depth->format());
    codec.color_range = AVCOL_RANGE_JPEG;
    codec.color_primaries = AVCOL_PRI_UNSPECIFIED;
    codec.color_trc = AVCOL_TRC_UNSPECIFIED;
    codec.colorspace = depth->format().layout == PlaneLayout::gbr ? AVCOL_SPC_RGB : AVCOL_SPC_UNSPECIFIED;
    codec.chroma_sample_location = AVCHROMA_LOC_UNSPECIFIED;
}

/// Fixed groups of pictures that can be entered at each key frame; frame data passed through. Depth has no eye to
/// please and no texture to hide in: what encoders do for these (adaptive quantisation, psychovisual decisions) and
/// what smooths its edges (loop filters) is off.
void set_encoder_options(const StreamSettings& settings, const TrackSettings& track, av::Options& options) {
    const bool depth = track.depth_code.has_value();
    options.set("preset", settings.preset);
    options.set("udu_sei", "1");
    options.set("crf", formatted("%g", track.crf.value_or(settings.crf)));
    if (settings.live) {
        options.set("tune", "zerolatency");
        options.set("forced-idr", "1");
    }
    if (track.codec(settings.codec) == Codec::h264) {
        options.set("sc_threshold", "0");
        std::string more = depth ? "aq-mode=0:psy=0:no-deblock=1" : "";
        const auto add = [&](const std::string& option) { more += (more.empty() ? "" : ":") + option; };
        if (settings.live)
            add("stitchable=1");  // parameter sets do not hang on quality (follow_settings)
        // libx264's AVX-512 macroblock tree reads memory that was never written: other bytes each time, and worse.
        if ((av_get_cpu_flags() & AV_CPU_FLAG_AVX512) != 0)
            add("asm=avx2");
        if (!more.empty())
            options.set("x264-params", more);
        return;
    }
    std::string more = "log-level=none:info=0:frame-threads=" + std::to_string(std::min(settings.threads, 16)) +
                       ":open-gop=0:scenecut=0:min-keyint=" + std::to_string(settings.gop);
    if (depth)
        more += ":aq-mode=0:psy-rd=0:psy-rdoq=0:no-deblock=1:no-sao=1:no-strong-intra-smoothing=1";
    if (track.depth_code == DepthCodeId::lossless)
        more += ":lossless=1";
    options.set("x265-params", more);
}

av::Codec open_encoder(const StreamSettings& settings, const TrackSettings& track, const DepthCode* depth,
                       bool global_header) {
    const char* name = track.codec(settings.codec) == Codec::h264 ? "libx264" : "libx265";
    const AVCodec* encoder = avcodec_find_encoder_by_name(name);
    if (!encoder)
        throw InputError(std::string(name) + ": this libavcodec was built without it");
    av::Codec codec(avcodec_alloc_context3(encoder));
    if (!codec)
        throw std::bad_alloc();
    codec->width = track.coded_width();
    codec->height = track.coded_height();
    codec->framerate = frame_rate_of(settings);
    codec->time_base = av_inv_q(codec->framerate);
    codec->sample_aspect_ratio = {1, 1};
    codec->gop_size = settings.live ? endless_group : settings.gop;
    codec->thread_count = settings.threads;
    set_colour_tags(*codec, settings.transfer, depth);
    if (global_header)
        codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    av::Options options;
    set_encoder_options(settings, track, options);
    const int code = avcodec_open2(codec.get(), encoder, options.taken());
    if (code < 0)
        throw InputError(std::string(name) + " refused " + size_text(codec->width, codec->height) + ", " +
                         av_get_pix_fmt_name(codec->pix_fmt) + ", preset " + settings.preset + ": " +
                         av::error_text(code));
    options.require_all_taken(std::string(name) + " of this libavcodec");
    return codec;
}

}  // namespace

Codec TrackSettings::codec(Codec stream_codec) const {
    const bool only_h265 =
        depth_code == DepthCodeId::w12 || depth_code == DepthCodeId::hue || depth_code == DepthCodeId::lossless;
    return only_h265 ? Codec::h265 : stream_codec;
}

std::optional<double> TrackSettings::coded_crf(double stream_crf) const {
    if (depth_code == DepthCodeId::lossless)
        return std::nullopt;
    return crf.value_or(stream_crf);
}

AVRational frame_rate_of(const StreamSettings& settings) {
    return av_d2q(settings.frames_per_second, 100000);
}

void check_coding(const StreamSettings& settings, const std::string& before_names) {
    if (!(settings.crf >= 0 && settings.crf <= worst_crf))
        throw InputError(
            expected_found(before_names + "crf", "0 to " + std::to_string(worst_crf), formatted("%g", settings.crf)));
    check_whole_number(before_names + "gop", settings.gop, 1, max_group_pictures);
    check_whole_number(before_names + "threads", settings.threads, 1, max_threads);
    check_preset(before_names + "preset", settings.preset);
}

void check_stream_settings(const StreamSettings& settings) {
    check_coding(settings);
    if (!(settings.frames_per_second >= 0.01 && settings.frames_per_second <= 1000))
        throw InputError(
            expected_found("frames per second", "0.01 to 1000", std::to_string(settings.frames_per_second)));
    if (settings.tracks.empty())
        throw InputError(expected_found("stream", "at least one track", "none"));
    if (settings.tracks.size() > max_stream_tracks)
        throw InputError(expected_found("stream", "at most " + std::to_string(max_stream_tracks) + " tracks",
                                        std::to_string(settings.tracks.size())));
    if (settings.live && settings.pictures > 0)
        throw InputError(expected_found("live stream", "no number of pictures", std::to_string(settings.pictures)));
    for (const TrackSettings& track : settings.tracks) {
        check_track(track);
        if (!may_be_tiled(track.role) &&
            std::count_if(settings.tracks.begin(), settings.tracks.end(),
                          [&](const TrackSettings& other) { return other.role == track.role; }) > 1)
            throw InputError(expected_found("stream", "each track once", std::string("two ") + track_name(track.role)));
    }
}

TrackEncoder::TrackEncoder(const StreamSettings& settings, const TrackSettings& track, bool global_header)
    : settings_(settings), track_(track), depth_code_(track.depth_code ? make_depth_code(*track.depth_code) : nullptr),
      codec_(open_encoder(settings, track, depth_code_.get(), global_header)) {
    if (const auto crf = track.coded_crf(settings.crf))
        crf_ = opened_crf_ = static_cast<float>(*crf);
    is_outdated_ = global_header && settings.live && codec_->codec_id == AV_CODEC_ID_H264;
}

void TrackEncoder::set_crf(double crf) {
    const std::string where = std::string(track_name(track_.role)) + " track";
    if (!(crf >= 0 && crf <= worst_crf))
        throw InputError(expected_found(where, "crf of 0 to " + std::to_string(worst_crf), std::to_string(crf)));
    if (codec_->codec_id != AV_CODEC_ID_H264 || !crf_)
        throw WorkError(
            expected_found(where, "H.264, whose quality can change from picture to picture", codec_->codec->name));
    constexpr float differs = 1;
    crf_ = static_cast<float>(crf);
    has_strayed_ = has_strayed_ || std::abs(*crf_ - *opened_crf_) >= differs;
    av_opt_set_double(codec_->priv_data, "crf", crf, 0);
}

void TrackEncoder::set_size(int width, int height) {
    TrackSettings resized = track_;
    resized.width = width;
    resized.height = height;
    check_track(resized);
    if (codec_->codec_id != AV_CODEC_ID_H264)
        throw WorkError(expected_found(std::string(track_name(track_.role)) + " track",
                                       "H.264, whose size can change from group to group", codec_->codec->name));
    track_ = resized;
    is_outdated_ = true;
}

/// Another encoder goes on where a group begins. No picture waits in that of a live stream.
void TrackEncoder::follow_settings() {
    const bool is_outdated = std::exchange(is_outdated_, false);
    if (!settings_.live || (!std::exchange(has_strayed_, false) && !is_outdated))
        return;
    TrackSettings track = track_;
    if (crf_)
        track.crf = *crf_;
    codec_ = open_encoder(settings_, track, depth_code_.get(), false);  // parameter sets come in packets
    opened_crf_ = crf_;
}

void TrackEncoder::require_size(int width, int height, int channels, int wanted_channels) const {
    const auto text = [](int w, int h, int c) {
        return size_text(w, h) + " with " + std::to_string(c) + (c == 1 ? " channel" : " channels");
    };
    if (width != track_.width || height != track_.height || channels != wanted_channels)
        throw WorkError(expected_found(std::string(track_name(track_.role)) + " track",
                                       text(track_.width, track_.height, wanted_channels),
                                       text(width, height, channels)));
}

void TrackEncoder::require_colour(Transfer transfer) const {
    const auto name = [](Transfer of) { return of == Transfer::pq ? "PQ" : "RGB"; };
    if (depth_code_ || transfer != settings_.transfer)
        throw WorkError(expected_found(std::string(track_name(track_.role)) + " track",
                                       depth_code_ ? "depth" : name(settings_.transfer), name(transfer)));
}

av::Frame TrackEncoder::convert(ImageView<const std::uint8_t> rgb) const {
    require_colour(Transfer::srgb);
    require_size(rgb.width, rgb.height, rgb.channels, 3);
    return yuv_frame_of(rgb);
}

av::Frame TrackEncoder::convert_pq(ImageView<const float> rgb) const {
    require_colour(Transfer::pq);
    require_size(rgb.width, rgb.height, rgb.channels, 3);
    return pq_frame_of(rgb);
}

av::Frame TrackEncoder::convert(ImageView<const float> depth_m, DepthCodeInfo& info) const {
    if (!depth_code_ || info.code != depth_code_->id())
        throw WorkError(expected_found(std::string(track_name(track_.role)) + " track",
                                       depth_code_ ? depth_code_name(depth_code_->id()) : "RGB",
                                       "depth to be coded as " + std::string(depth_code_name(info.code))));
    require_size(depth_m.width, depth_m.height, depth_m.channels, 1);
    info.halved = track_.halved;
    FloatImage half_m;
    if (track_.halved) {
        half_m = halve_depth(depth_m);
        depth_m = half_m.view();
    }
    av::Frame frame = av::make_frame(pixel_format_of(depth_code_->format()), depth_m.width, depth_m.height);
    frame->color_range = codec_->color_range;
    frame->colorspace = codec_->colorspace;
    info.clamped_pixels =
        static_cast<std::uint32_t>(depth_code_->pack(depth_m, info.range, planes_of(*frame, depth_code_->format())));
    return frame;
}

void TrackEncoder::encode(av::Frame picture, std::int64_t pts, std::span<const std::uint8_t> payload,
                          const std::function<void(AVPacket&)>& emit) {
    if (picture->pict_type == AV_PICTURE_TYPE_I)
        follow_settings();
    picture->pts = pts;
    if (!payload.empty()) {
        AVFrameSideData* data = av_frame_new_side_data(picture.get(), AV_FRAME_DATA_SEI_UNREGISTERED, payload.size());
        if (!data)
            throw std::bad_alloc();
        std::copy(payload.begin(), payload.end(), data->data);
    }
    send(picture.get(), emit);
}

void TrackEncoder::send(const AVFrame* picture, const std::function<void(AVPacket&)>& emit) {
    int code = avcodec_send_frame(codec_.get(), picture);
    pictures_ += picture != nullptr ? 1 : 0;
    // libx265 takes the decoding time of pictures from memory that it has not written yet when the track ends before
    // its longest reordering, of two pictures. Two and fewer are decoded in the order they are shown in.
    const bool unordered = picture == nullptr && pictures_ <= longest_reordering;
    while (code >= 0) {
        code = avcodec_receive_packet(codec_.get(), packet_.get());
        if (unordered)
            packet_->dts = packet_->pts;
        if (code >= 0)
            emit(*packet_);
        av_packet_unref(packet_.get());
    }
    if (code != AVERROR(EAGAIN) && code != AVERROR_EOF)
        throw WorkError(std::string(codec_->codec->name) + ": " + av::error_text(code));
}

}  // namespace equistream
