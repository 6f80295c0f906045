#include "track_decoder.h"

#include <equistream/camera_limits.h>
#include <equistream/elapsed.h>
#include <equistream/error.h>
#include <equistream/text.h>

extern "C" {
#include <libavutil/pixdesc.h>
#include <libavutil/spherical.h>
#include <libavutil/stereo3d.h>
}

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace equistream {

namespace {

/// By so many pictures at most one comes late.
constexpr std::uint32_t most_late = 64;

/// What travels with a packet through the decoder to its picture, in the one number that libav takes along.
std::int64_t mark_of(int packet_bytes, bool suspect) {
    return std::int64_t{packet_bytes} * 2 + (suspect ? 1 : 0);
}
std::int64_t bytes_in(std::int64_t mark) {
    return std::max<std::int64_t>(mark, 0) / 2;
}
bool is_suspect(std::int64_t mark) {
    return mark % 2 == 1;
}

bool is_acceptable_size(int width, int height) {
    return width > 0 && height > 0 && width <= max_image_side && height <= max_image_side &&
           std::int64_t{width} * height <= max_image_pixels;
}

void check_size(const std::string& source, int width, int height) {
    if (!is_acceptable_size(width, height))
        throw InputError(expected_found(source, "pictures of at most " + std::to_string(max_image_side) + " a side",
                                        size_text(width, height)));
}

av::Codec open_decoder(const AVStream& stream, const std::string& source, const HardwareDecoding& hardware,
                       DecoderCallbacks& callbacks, int threads) {
    const AVCodecParameters& parameters = *stream.codecpar;
    const AVCodec* decoder = avcodec_find_decoder(parameters.codec_id);
    if (!decoder)
        throw InputError(
            expected_found(source, "video this libavcodec can decode", avcodec_get_name(parameters.codec_id)));
    av::Codec codec(avcodec_alloc_context3(decoder));
    if (!codec || avcodec_parameters_to_context(codec.get(), &parameters) < 0)
        throw std::bad_alloc();
    codec->pkt_timebase = stream.time_base;
    codec->thread_count = threads;
    // Decoders that work on several pictures at once give each one only when the next ones have come.
    if (is_url(source) && parameters.video_delay == 0)
        codec->thread_type = FF_THREAD_SLICE;
    codec->max_pixels = max_image_pixels;
    codec->opaque = &callbacks;
    hardware.offer_to(*codec, callbacks);
    if (callbacks.memory != nullptr)
        render_into_memory(*codec);
    codec->err_recognition = AV_EF_CRCCHECK | AV_EF_BITSTREAM | AV_EF_BUFFER | AV_EF_EXPLODE;
    if (const int code = avcodec_open2(codec.get(), decoder, nullptr); code < 0)
        throw InputError(expected_found(source, "a track that " + std::string(decoder->name) + " decodes",
                                        "none (libav: " + av::error_text(code) + ")"));
    return codec;
}

std::optional<TaggedFrameInfo> frame_info_of(const AVFrame& frame) {
    for (int i = 0; i < frame.nb_side_data; ++i) {
        const AVFrameSideData& data = *frame.side_data[i];
        if (data.type == AV_FRAME_DATA_SEI_UNREGISTERED)
            if (auto tagged = decode_frame_info({data.data, data.size}))
                return tagged;
    }
    return std::nullopt;
}

/// Half the columns and rows of the picture that it says it is of.
bool is_half_of(const AVFrame& frame, const FrameInfo& info) {
    const int width = picture_width(info), height = picture_height(info);
    return is_acceptable_size(width, height) && frame.width * 2 == width && frame.height * 2 == height;
}

/// Depth needs its code, in samples of that code, and its size; colour has none. A window's size may change: where the
/// key frame of the new one was lost, its other pictures are decoded as if they had the old one.
bool fits_role(const AVFrame& frame, const TaggedFrameInfo& tagged) {
    const auto& depth_code = tagged.info.depth_code;
    if (is_depth(tagged.role) != depth_code.has_value())
        return false;
    const bool is_halved = depth_code && depth_code->halved;
    if (may_be_tiled(tagged.role) && !is_halved &&
        (frame.width != picture_width(tagged.info) || frame.height != picture_height(tagged.info)))
        return false;
    if (depth_code && depth_code->halved && (!may_be_halved(tagged.role) || !is_half_of(frame, tagged.info)))
        return false;
    return !depth_code || decoded_planes(frame, make_depth_code(depth_code->code)->format()).has_value();
}

bool is_damaged(const AVFrame& frame) {
    return (frame.flags & AV_FRAME_FLAG_CORRUPT) != 0 || frame.decode_error_flags != 0;
}

std::string name_or(const char* name) {
    return name ? name : "unknown";
}

/// What a track is tagged with, if it is.
template <typename Data>
const Data* side_data(const AVStream& stream, AVPacketSideDataType type) {
    std::size_t size = 0;
    const auto* data = av_stream_get_side_data(&stream, type, &size);
    return size >= sizeof(Data) ? reinterpret_cast<const Data*>(data) : nullptr;
}

std::string colour_of(const AVCodecParameters& parameters) {
    return name_or(av_color_range_name(parameters.color_range)) + "/" +
           name_or(av_color_primaries_name(parameters.color_primaries)) + "/" +
           name_or(av_color_transfer_name(parameters.color_trc)) + "/" +
           name_or(av_color_space_name(parameters.color_space));
}

/// What libavformat found of sv3d (Matroska: Projection). Bounds say what is cut off at each side.
std::optional<LongitudeLatitudeRange> sphere_of(const AVStream& stream) {
    const auto* mapping = side_data<AVSphericalMapping>(stream, AV_PKT_DATA_SPHERICAL);
    if (!mapping || (mapping->projection != AV_SPHERICAL_EQUIRECTANGULAR &&
                     mapping->projection != AV_SPHERICAL_EQUIRECTANGULAR_TILE))
        return std::nullopt;
    constexpr double whole = 4294967296.0;
    const LongitudeLatitudeRange range{
        2 * pi * (mapping->bound_left / whole - 0.5), 2 * pi * (0.5 - mapping->bound_right / whole),
        pi * (mapping->bound_bottom / whole - 0.5), pi * (0.5 - mapping->bound_top / whole)};
    if (longitudes_mismatch(range.longitude_min, range.longitude_max) ||
        latitudes_mismatch(range.latitude_min, range.latitude_max))
        return std::nullopt;
    return range;
}

/// What libavformat found of st3d (Matroska: StereoMode).
void read_stereo(const AVStream& stream, StreamTrackSummary& summary) {
    const auto* stereo = side_data<AVStereo3D>(stream, AV_PKT_DATA_STEREO3D);
    if (!stereo)
        return;
    summary.stereo = stereo->type == AV_STEREO3D_TOPBOTTOM    ? StereoPacking::top_bottom
                     : stereo->type == AV_STEREO3D_SIDEBYSIDE ? StereoPacking::side_by_side
                                                              : StereoPacking::none;
    summary.right_first = summary.stereo != StereoPacking::none && (stereo->flags & AV_STEREO3D_FLAG_INVERT) != 0;
}

std::string track_title(const AVStream& stream) {
    for (const char* key : {"title", "handler_name"})
        if (const AVDictionaryEntry* entry = av_dict_get(stream.metadata, key, nullptr, 0))
            return entry->value;
    return "";
}

/// The least rate that all times fit. Where libav finds none it takes the ticks of the container's clock for pictures,
/// and of interlaced video it takes fields for them.
double rate_of_all_times(const AVStream& stream, double mean) {
    constexpr double highest_likely = 240, rounding = 1e-3;
    const AVRational rate = stream.r_frame_rate;
    const double least = rate.num > 0 && rate.den > 0 ? av_q2d(rate) : 0;
    const bool counts_fields = std::abs(least - 2 * mean) < rounding * mean;
    return least > highest_likely || counts_fields ? mean : std::max(mean, least);
}

StreamTrackSummary summarise(const AVStream& stream, TrackRole role) {
    const AVCodecParameters& parameters = *stream.codecpar;
    StreamTrackSummary summary;
    summary.role = role;
    summary.name = track_title(stream);
    summary.codec = avcodec_get_name(parameters.codec_id);
    summary.width = parameters.width;
    summary.height = parameters.height;
    const AVRational rate = stream.avg_frame_rate.num > 0 ? stream.avg_frame_rate : stream.r_frame_rate;
    summary.frames_per_second = rate.den > 0 ? av_q2d(rate) : 0;
    summary.max_frames_per_second = rate_of_all_times(stream, summary.frames_per_second);
    summary.pixel_format = name_or(av_get_pix_fmt_name(static_cast<AVPixelFormat>(parameters.format)));
    summary.colour = colour_of(parameters);
    summary.sphere = sphere_of(stream);
    read_stereo(stream, summary);
    return summary;
}

}  // namespace

TrackDecoder::TrackDecoder(const AVStream& stream, TrackRole assumed_role, const std::string& source,
                           const StreamReadOptions& options, int threads)
    : source_(source), stream_(stream) {
    check_size(source, stream.codecpar->width, stream.codecpar->height);
    if (options.hardware && !is_depth(assumed_role))
        hardware_.look_for(*stream.codecpar);
    if (!is_depth(assumed_role))  // which is read here, sample by sample
        callbacks_.memory = options.memory;
    codec_ = open_decoder(stream, source, hardware_, callbacks_, threads);
    summary_ = summarise(stream, assumed_role);
    tally_.role = assumed_role;
}

void TrackDecoder::take_tags(const SpatialTags& tags) {
    if (!summary_.sphere)
        summary_.sphere = tags.sphere;
    if (summary_.stereo == StereoPacking::none) {
        summary_.stereo = tags.stereo;
        summary_.right_first = tags.right_first;
    }
    summary_.baseline_m = tags.baseline_m;
    summary_.has_vexu = true;
}

void TrackDecoder::decode(const AVPacket& packet, bool suspect) {
    summary_.bytes += packet.size;
    codec_->reordered_opaque = mark_of(packet.size, suspect);
    send(&packet);
}

void TrackDecoder::drain() {
    send(nullptr);
    // If a track is not complete with a packet that may have been cut short, that packet's picture cannot be trusted:
    // half a picture may well decode. What is missing among those that were given does not make it incomplete.
    std::int64_t count = tally_.count, given = tally_.expected;
    bool jumped = jumping_;
    for (const Ready& ready : ready_) {
        if (!ready.tagged)
            continue;
        count = std::max<std::int64_t>(count, ready.tagged->position.count);
        if (std::exchange(jumped, false))
            given = ready.tagged->position.ordinal;
    }
    const auto suspect =
        std::find_if(ready_.begin(), ready_.end(), [](const Ready& ready) { return ready.suspect && ready.tagged; });
    if (suspect == ready_.end() || given + std::ssize(ready_) == count)
        return;
    ready_.erase(suspect);
    ++tally_.unreadable;
}

void TrackDecoder::jump() {
    avcodec_flush_buffers(codec_.get());
    ready_.clear();
    busy_ms_ = 0;
    accepted_.ordinal = 0;
    begins_again_ = false;
    tally_.pictures = tally_.missing = tally_.unreadable = 0;
    tally_.expected = 0;
    jumping_ = tally_.jumped = true;
}

void TrackDecoder::send(const AVPacket* packet) {
    const auto start = Clock::now();
    int code = avcodec_send_packet(codec_.get(), packet);
    if (code == AVERROR(EAGAIN)) {
        receive();
        code = avcodec_send_packet(codec_.get(), packet);
    }
    busy_ms_ += milliseconds_since(start);
    if (code < 0 && code != AVERROR_EOF)
        ++tally_.unreadable;
    receive();
}

void TrackDecoder::receive() {
    for (;;) {
        av::Frame frame = av::make_frame();
        const auto start = Clock::now();
        const int code = avcodec_receive_frame(codec_.get(), frame.get());
        busy_ms_ += milliseconds_since(start);
        if (code == AVERROR(EAGAIN) || code == AVERROR_EOF)
            return;
        if (code < 0)
            ++tally_.unreadable;
        else
            accept(std::move(frame));
    }
}

void TrackDecoder::note(const TaggedFrameInfo& tagged) {
    const std::uint32_t ordinal = tagged.position.ordinal;
    tally_.count = std::max(tally_.count, tagged.position.count);
    tally_.role = summary_.role = tagged.role;
    // After damage a decoder with several threads may give a picture late. It was counted as missing.
    if (!jumping_ && tally_.missing > 0 && ordinal < tally_.expected && tally_.expected - ordinal <= most_late) {
        --tally_.missing;
        return;
    }
    if (std::exchange(jumping_, false))
        tally_.pictures = std::int64_t{ordinal} + 1;
    else if (ordinal > tally_.expected && !tally_.partial && (tally_.ours || !joined_anywhere_))
        tally_.missing += ordinal - tally_.expected;
    tally_.ours = true;
    tally_.expected = ordinal + 1;
    tally_.last_index = tagged.info.index;
}

bool TrackDecoder::is_repetition(const TrackPosition& position) {
    const bool is_whole = accepted_.count > 0 && accepted_.ordinal >= accepted_.count;
    begins_again_ = begins_again_ || (is_whole && position.ordinal < accepted_.ordinal);
    accepted_.ordinal = position.ordinal + 1;
    accepted_.count = std::max(accepted_.count, position.count);
    return begins_again_;
}

/// What a tile's picture would say that carries no data of its own.
std::optional<TaggedFrameInfo> TrackDecoder::of_group(const AVFrame& frame) const {
    const std::optional<double> time_s = time_of_s(frame.best_effort_timestamp);
    if (!group_ || !time_s)
        return std::nullopt;
    TaggedFrameInfo tagged = group_->first;
    const double pictures = std::round((*time_s - group_->time_s) * tagged.info.frames_per_second);
    if (!(pictures > 0 && pictures < max_group_pictures))
        return std::nullopt;
    tagged.info.index += std::int64_t(pictures);
    tagged.info.time_s += pictures / tagged.info.frames_per_second;
    tagged.position.ordinal += std::uint32_t(pictures);
    return tagged;
}

void TrackDecoder::accept(av::Frame frame) {
    const std::string_view decoder = hardware_.name_of(*frame);
    if (!hardware_.fetch(frame, callbacks_.memory.get())) {
        ++tally_.unreadable;
        return;
    }
    av::forget_unknown_colours(*frame);
    if (is_damaged(*frame) || !is_acceptable_size(frame->width, frame->height)) {
        ++tally_.unreadable;
        return;
    }
    std::optional<TaggedFrameInfo> tagged;
    try {
        tagged = frame_info_of(*frame);
        if (const auto time_s = time_of_s(frame->best_effort_timestamp); is_tile_ && tagged && time_s)
            group_ = {*tagged, *time_s};
        else if (is_tile_ && !tagged)
            tagged = of_group(*frame);
        if (tagged && !fits_role(*frame, *tagged)) {
            ++tally_.unreadable;
            return;
        }
    } catch (const InputError& error) {
        // A stream is of one version: once a picture could be read, another number is damage.
        if (!version_is_known_)
            throw InputError(source_ + ": " + error.what());
        ++tally_.unreadable;
        return;
    } catch (const WorkError&) {
        ++tally_.unreadable;
        return;
    }
    version_is_known_ = version_is_known_ || tagged;
    if (tagged && is_repetition(tagged->position))
        return;
    const bool suspect = is_suspect(frame->reordered_opaque);
    ready_.push_back({std::move(frame), std::move(tagged), decoder, std::exchange(busy_ms_, 0), suspect});
}

std::optional<double> TrackDecoder::next_time_s() const {
    if (ready_.empty())
        return std::nullopt;
    return time_of_s(ready_.front().frame->best_effort_timestamp).value_or(std::numeric_limits<double>::lowest());
}

std::optional<double> TrackDecoder::time_of_s(std::int64_t timestamp) const {
    return timestamp == AV_NOPTS_VALUE ? std::nullopt
                                       : std::optional(static_cast<double>(timestamp) * av_q2d(stream_.time_base));
}

void TrackDecoder::give_colour(av::Frame frame, const StreamReadOptions& options, DecodedPicture& picture) {
    if (options.yuv && is_our_yuv420(*frame)) {
        const std::shared_ptr<const AVFrame> owner(frame.release(), av::Delete());
        picture.yuv = {yuv420_planes_of(*owner), owner};
    } else if (options.pq && is_pq(*frame)) {
        av::Frame ours = is_our_pq420(*frame) ? std::move(frame) : to_pq_.scaled(*frame);
        const std::shared_ptr<const AVFrame> owner(ours.release(), av::Delete());
        picture.pq = {pq420_planes_of(*owner), owner};
    } else if (options.rgb) {
        picture.rgb = rgb_of(*frame, to_rgb_);
    }
}

void TrackDecoder::give_depth(const AVFrame& frame, DecodedPicture& picture) {
    const DepthCodeInfo& info = *picture.info->depth_code;
    if (!depth_code_ || depth_code_->id() != info.code)
        depth_code_ = make_depth_code(info.code);
    FloatImage coded_m(frame.width, frame.height, 1);
    depth_code_->unpack(*decoded_planes(frame, depth_code_->format()), info.range, coded_m.view());
    picture.depth_m = info.halved ? double_depth(coded_m.view()) : std::move(coded_m);
    picture.width = picture.depth_m.width();
    picture.height = picture.depth_m.height();
}

std::optional<DecodedPicture> TrackDecoder::take(const StreamReadOptions& options) {
    if (ready_.empty())
        return std::nullopt;
    Ready ready = std::move(ready_.front());
    ready_.pop_front();
    DecodedPicture picture;
    picture.role = tally_.role;
    picture.width = ready.frame->width;
    picture.height = ready.frame->height;
    picture.decoder = ready.decoder;
    picture.decode_ms = ready.decode_ms;
    picture.bytes = bytes_in(ready.frame->reordered_opaque);
    picture.time_s = time_of_s(ready.frame->best_effort_timestamp);
    ++tally_.pictures;
    ++summary_.pictures;
    if (ready.tagged) {
        note(*ready.tagged);
        picture.role = ready.tagged->role;
        picture.info = ready.tagged->info;
        picture.ordinal = ready.tagged->position.ordinal;
    }
    const auto start = Clock::now();
    if (!picture.info || !picture.info->depth_code)
        give_colour(std::move(ready.frame), options, picture);
    else if (options.wants(picture.role))
        give_depth(*ready.frame, picture);
    picture.convert_ms = milliseconds_since(start);
    return picture;
}

void TrackDecoder::leave_out() {
    tally_.left_out = true;
    ready_.clear();
}
}  // namespace equistream
