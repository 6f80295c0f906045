#include "output.h"
#include "spatial_boxes.h"
#include "track_encoder.h"

#include <equistream/camera_limits.h>
#include <equistream/depth_code.h>
#include <equistream/error.h>
#include <equistream/stream.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

extern "C" {
#include <libavutil/spherical.h>
#include <libavutil/stereo3d.h>
}

namespace equistream {

namespace {

/// libavformat keeps a fragment until it is whole: 2 GiB of a track at most, and a box holds 4 GiB.
constexpr std::int64_t max_fragment_bytes = std::int64_t{1} << 30;
/// So that what is shown later begins a cluster of its own, and viewers who are behind can skip from there (serve).
constexpr int max_cluster_bytes = 1 << 15, max_cluster_ms = 1;

struct WrittenTrack {
    WrittenTrack(const StreamSettings& settings, const TrackSettings& track, bool global_header)
        : role(track.role), codec(track.codec(settings.codec)), encoder(settings, track, global_header) {}

    TrackRole role;
    Codec codec;
    TrackEncoder encoder;
    AVStream* stream = nullptr;
    std::int64_t bytes = 0;
    std::uint32_t pictures = 0;  ///< handed to the encoder
    std::optional<std::int64_t> last_index, coded_index;
    av::Frame held;  ///< the newest picture, while the track's length is not known: of a live stream coded already
    FrameInfo held_info;
    bool begins_group = false;            ///< with the next picture
    std::optional<std::int64_t> earlier;  ///< by so many pictures it is decoded, so that all tracks begin to be at once
};

/// Takes `data`, which is libav's.
template <typename Data>
void add_side_data(AVStream& stream, AVPacketSideDataType type, Data* data, std::size_t size) {
    if (av_stream_add_side_data(&stream, type, reinterpret_cast<std::uint8_t*>(data), size) < 0) {
        av_free(data);
        throw std::bad_alloc();
    }
}

/// Players know only spheres whose middle is ahead, whole or in part.
bool can_be_tagged(const LongitudeLatitudeRange& range) {
    constexpr double rounding = 1e-9;
    return range.longitude_min >= -pi - rounding && range.longitude_max <= pi + rounding;
}

/// Of a part of the sphere: bounds say what is cut off at each side.
void tag_as_equirect(AVStream& stream, const LongitudeLatitudeRange& range) {
    std::size_t size = 0;
    AVSphericalMapping* mapping = av_spherical_alloc(&size);
    if (!mapping)
        throw std::bad_alloc();
    mapping->projection = range.is_full_sphere() ? AV_SPHERICAL_EQUIRECTANGULAR : AV_SPHERICAL_EQUIRECTANGULAR_TILE;
    const auto bound = [](double share) {
        return std::uint32_t(std::llround(std::clamp(share, 0.0, 1.0) * std::numeric_limits<std::uint32_t>::max()));
    };
    mapping->bound_left = bound(0.5 + range.longitude_min / (2 * pi));
    mapping->bound_right = bound(0.5 - range.longitude_max / (2 * pi));
    mapping->bound_top = bound(0.5 - range.latitude_max / pi);
    mapping->bound_bottom = bound(0.5 + range.latitude_min / pi);
    add_side_data(stream, AV_PKT_DATA_SPHERICAL, mapping, size);
}

void tag_as_stereo(AVStream& stream, StereoPacking packing) {
    AVStereo3D* stereo = av_stereo3d_alloc();
    if (!stereo)
        throw std::bad_alloc();
    stereo->type = packing == StereoPacking::top_bottom ? AV_STEREO3D_TOPBOTTOM : AV_STEREO3D_SIDEBYSIDE;
    add_side_data(stream, AV_PKT_DATA_STEREO3D, stereo, sizeof *stereo);
}

void require(const std::string& what, const std::optional<Mismatch>& mismatch) {
    if (mismatch)
        throw InputError(expected_found(what, mismatch->expected, mismatch->found));
}

/// What an mp4 says of its tracks at first, or of the pictures of a group.
std::size_t max_header_bytes(const StreamSettings& settings) {
    constexpr std::size_t of_track = 8192, of_picture = 40;
    return settings.tracks.size() * (of_track + of_picture * std::size_t(settings.gop));
}

void check_fits(const std::string& target, const Container& container, const StreamSettings& settings) {
    if (container.one_track && settings.tracks.size() > 1)
        throw InputError(
            expected_found(target, "one track (raw video holds no more)", std::to_string(settings.tracks.size())));
    if (container.only_for_codec && *container.only_for_codec != settings.tracks.front().codec(settings.codec))
        throw InputError(expected_found(target,
                                        *container.only_for_codec == Codec::h265 ? "a name ending in .h264 for H.264"
                                                                                 : "a name ending in .h265 for H.265",
                                        "the extension of the other codec"));
}

}  // namespace

struct StreamWriter::State {
    State(const std::string& target_name, const StreamSettings& stream_settings, std::optional<StreamTap> tap);
    ~State();

    void open_format();
    void add_stream(WrittenTrack& track);
    bool tags_sphere() const { return settings.sphere && container.tags_spheres && can_be_tagged(*settings.sphere); }
    bool is_mp4() const { return std::string_view(container.muxer) == "mp4"; }
    bool is_matroska() const { return std::string_view(container.muxer) == "matroska"; }
    void write_header();
    void write_header_with_vexu();
    WrittenTrack& track_of(TrackRole role, std::size_t tile);
    bool is_tile(const WrittenTrack& track) const;
    /// The track that takes this frame next.
    WrittenTrack& start_picture(TrackRole role, const FrameInfo& info, std::size_t tile);
    void take(WrittenTrack& track, av::Frame picture, const FrameInfo& info);
    void take_live(WrittenTrack& track, av::Frame picture, const FrameInfo& info);
    void encode(WrittenTrack& track, av::Frame picture, const FrameInfo& info, std::uint32_t count);
    void end_track(WrittenTrack& track, bool whole);
    void begin_together(WrittenTrack& track, AVPacket& packet) const;
    void write_packet(WrittenTrack& track, AVPacket& packet);
    /// `whole`: the last pictures may say that they are the last.
    void end_tracks(bool whole);
    void check(int code, const char* doing);

    std::string target;
    StreamSettings settings;
    Container container;
    std::vector<std::unique_ptr<WrittenTrack>> tracks;
    std::unique_ptr<Output> output;
    av::Muxer format;
    std::optional<std::int64_t> first_index;
    bool header_written = false;
    bool over = false;  ///< finished or failed: nothing more may be written
};

StreamWriter::State::State(const std::string& target_name, const StreamSettings& stream_settings,
                           std::optional<StreamTap> tap)
    : target(target_name), settings(stream_settings), container(choose_container(target_name)) {
    av::silence_log();
    check_stream_settings(settings);
    check_fits(target, container, settings);
    open_format();
    for (const TrackSettings& track : settings.tracks) {
        tracks.push_back(
            std::make_unique<WrittenTrack>(settings, track, (format->oformat->flags & AVFMT_GLOBALHEADER) != 0));
        add_stream(*tracks.back());
    }
    output = std::make_unique<Output>(target, std::move(tap), is_mp4() ? max_header_bytes(settings) : 0);
    format->pb = output->io();
    write_header();
}

StreamWriter::State::~State() {
    if (over || !header_written)
        return;
    try {  // a caller that failed keeps what it had coded
        end_tracks(false);
    } catch (const std::exception&) {
        over = true;
    }
}

void StreamWriter::State::check(int code, const char* doing) {
    if (code >= 0 && output->io()->error >= 0)
        return;
    over = true;
    output->flush();  // throws with the operating system's reason, if that is what failed
    throw WorkError(target + ": " + doing + ": " + av::error_text(code));
}

void StreamWriter::State::open_format() {
    AVFormatContext* opened = nullptr;
    if (avformat_alloc_output_context2(&opened, nullptr, container.muxer, nullptr) < 0)
        throw InputError(target + ": this libavformat cannot write " + container.muxer);
    format.reset(opened);
    format->flags |= AVFMT_FLAG_BITEXACT;                        // no random ids, no dates
    format->strict_std_compliance = FF_COMPLIANCE_EXPERIMENTAL;  // spherical metadata in mp4
    if (is_url(target))
        format->flags |= AVFMT_FLAG_FLUSH_PACKETS;
    if (!settings.scene.empty())
        av_dict_set(&format->metadata, "title", settings.scene.c_str(), 0);
}

void StreamWriter::State::add_stream(WrittenTrack& track) {
    AVStream* stream = avformat_new_stream(format.get(), nullptr);
    const AVCodecContext& codec = track.encoder.codec();
    if (!stream || avcodec_parameters_from_context(stream->codecpar, &codec) < 0)
        throw std::bad_alloc();
    stream->time_base = codec.time_base;
    stream->avg_frame_rate = codec.framerate;
    stream->disposition = track.role == TrackRole::main ? AV_DISPOSITION_DEFAULT : 0;
    if (container.names_tracks)
        for (const char* key : {"title", "handler_name"})
            av_dict_set(&stream->metadata, key, track_name(track.role), 0);
    if (track.codec == Codec::h265 && is_mp4())
        stream->codecpar->codec_tag = MKTAG('h', 'v', 'c', '1');  // the one that every player takes
    if (tags_sphere() && track.role == TrackRole::main)
        tag_as_equirect(*stream, *settings.sphere);
    if (settings.stereo != StereoPacking::none && container.tags_spheres && track.role == TrackRole::main)
        tag_as_stereo(*stream, settings.stereo);
    track.stream = stream;
}

void StreamWriter::State::write_header() {
    av::Options options;
    // Written front to back, playable up to any cut: a fragment per group of pictures can be read without what follows.
    if (is_mp4()) {
        options.set("movflags", "frag_keyframe+empty_moov+default_base_moof");
        options.set("frag_size", std::to_string(max_fragment_bytes));
        options.set("frag_interleave", "1");  // else readers hold a group of one track until the next one's begins
    }
    // Ending a file, its muxer fills in where key frames are. By then clusters are as short as a socket would get them.
    if (is_matroska()) {
        options.set("cluster_size_limit", std::to_string(max_cluster_bytes));
        options.set("cluster_time_limit", std::to_string(max_cluster_ms));
    }
    check(avformat_init_output(format.get(), options.taken()), "preparing the container");
    options.require_all_taken(std::string("the container ") + container.muxer + " of this libavformat");
    if (is_mp4() && settings.tracks.front().role == TrackRole::main &&
        (settings.sphere || settings.stereo != StereoPacking::none))
        write_header_with_vexu();
    else
        check(avformat_write_header(format.get(), nullptr), "writing the header");
    output->flush();  // a full disk or a closed connection shows before any work is done
    header_written = true;
}

/// libavformat before 7.1 knows no vexu, so it is put into what that has written.
void StreamWriter::State::write_header_with_vexu() {
    SpatialTags tags{.sphere = tags_sphere() ? settings.sphere : std::nullopt, .stereo = settings.stereo};
    if (settings.stereo != StereoPacking::none && settings.baseline_m > 0)
        tags.baseline_m = settings.baseline_m;
    AVIOContext* memory = nullptr;
    if (avio_open_dyn_buf(&memory) < 0)
        throw std::bad_alloc();
    AVIOContext* const to_output = std::exchange(format->pb, memory);
    const int code = avformat_write_header(format.get(), nullptr);
    std::uint8_t* bytes = nullptr;
    const int size = avio_close_dyn_buf(memory, &bytes);
    format->pb = to_output;
    const std::unique_ptr<std::uint8_t, decltype(&av_free)> owner(bytes, &av_free);
    check(code, "writing the header");
    const auto header = with_box_in_first_entry({bytes, std::size_t(size)}, vexu_box(tags));
    avio_write(format->pb, header.data(), int(header.size()));
}

WrittenTrack& StreamWriter::State::track_of(TrackRole role, std::size_t tile) {
    for (const auto& track : tracks)
        if (track->role == role && tile-- == 0)
            return *track;
    throw WorkError(expected_found(target, "pictures of the tracks it was opened with", track_name(role)));
}

bool StreamWriter::State::is_tile(const WrittenTrack& track) const {
    return may_be_tiled(track.role) &&
           std::ranges::count_if(tracks, [&](const auto& other) { return other->role == track.role; }) > 1;
}

/// libx264 and libx265 reorder by other numbers of pictures. In an MP4 in fragments libavformat moves what begins to be
/// decoded later, but not its first picture.
void StreamWriter::State::begin_together(WrittenTrack& track, AVPacket& packet) const {
    const auto is_coded_otherwise = [&](const auto& other) { return other->codec != tracks.front()->codec; };
    if (!is_mp4() || std::ranges::none_of(tracks, is_coded_otherwise))
        return;
    if (!track.earlier)
        track.earlier = std::max<std::int64_t>(0, longest_reordering - (packet.pts - packet.dts));
    packet.dts -= *track.earlier;
}

void StreamWriter::State::write_packet(WrittenTrack& track, AVPacket& packet) {
    begin_together(track, packet);
    track.bytes += packet.size;
    packet.stream_index = track.stream->index;
    packet.duration = 1;
    av_packet_rescale_ts(&packet, track.encoder.codec().time_base, track.stream->time_base);
    const std::string doing = std::string("writing ") + track_name(track.role) + "'s packet of " +
                              std::to_string(packet.size) + " bytes, shown at " + std::to_string(packet.pts) +
                              " and decoded at " + std::to_string(packet.dts);
    check(av_interleaved_write_frame(format.get(), &packet), doing.c_str());
}

void StreamWriter::State::encode(WrittenTrack& track, av::Frame picture, const FrameInfo& info, std::uint32_t count) {
    std::vector<std::uint8_t> payload;
    // Pictures of a tile are so small that their frame data would outweigh them; main's say all but where tiles lie.
    // Without it pictures are numbered by when they are shown, and must follow each other; a reader knows tiles by
    // name.
    const bool follows = std::exchange(track.coded_index, info.index) == info.index - 1;
    const bool goes_on = follows && is_tile(track) && container.names_tracks && settings.pictures > 0 &&
                         track.pictures % std::uint32_t(settings.gop) != 0;
    if (settings.tagged && !goes_on) {
        FrameInfo coded = info;
        coded.crf = track.encoder.crf();
        payload = encode_frame_info(track.role, coded, {track.pictures, count});
    }
    ++track.pictures;
    track.encoder.encode(std::move(picture), info.index - *first_index, payload,
                         [&](AVPacket& packet) { write_packet(track, packet); });
}

void StreamWriter::State::end_track(WrittenTrack& track, bool whole) {
    if (settings.live) {
        ++track.held_info.index;
        track.held_info.time_s += 1 / settings.frames_per_second;
        if (track.held && track.begins_group)
            track.held->pict_type = AV_PICTURE_TYPE_I;
    }
    if (track.held && (whole || !settings.live))
        encode(track, std::move(track.held), track.held_info, whole ? track.pictures + 1 : 0);
    track.encoder.drain([&](AVPacket& packet) { write_packet(track, packet); });
}

void StreamWriter::State::end_tracks(bool whole) {
    for (const auto& track : tracks)
        end_track(*track, whole);
    check(av_write_trailer(format.get()), "ending");
    over = true;
}

StreamWriter::StreamWriter(const std::string& target, const StreamSettings& settings, std::optional<StreamTap> tap)
    : state_(std::make_unique<State>(target, settings, std::move(tap))) {}

StreamWriter::~StreamWriter() = default;

WrittenTrack& StreamWriter::State::start_picture(TrackRole role, const FrameInfo& info, std::size_t tile) {
    if (over)
        throw WorkError(target + ": has ended, nothing more can be written");
    WrittenTrack& track = track_of(role, tile);
    // A decoder refuses a picture whose data say otherwise.
    if (is_depth(role) != info.depth_code.has_value())
        throw WorkError(expected_found(target + ": " + track_name(role),
                                       is_depth(role) ? "a depth code and its range" : "colours, without a depth code",
                                       info.depth_code ? depth_code_name(info.depth_code->code) : "none"));
    require(target + ": frame number", range_mismatch(static_cast<double>(info.index), 0, max_frame_index));
    require(target + ": frame time", range_mismatch(info.time_s, -max_time_s, max_time_s));
    if (!first_index)
        first_index = info.index;
    if (info.index < track.last_index.value_or(*first_index - 1) + 1)
        throw WorkError(
            expected_found(target + ": " + track_name(role), "ascending frame numbers", std::to_string(info.index)));
    track.last_index = info.index;
    return track;
}

void StreamWriter::State::take(WrittenTrack& track, av::Frame picture, const FrameInfo& info) {
    if (settings.live)
        return take_live(track, std::move(picture), info);
    if (settings.pictures > 0)
        return encode(track, std::move(picture), info, settings.pictures);
    std::swap(track.held, picture);
    const FrameInfo previous = std::exchange(track.held_info, info);
    if (picture)
        encode(track, std::move(picture), previous, 0);
}

void StreamWriter::State::take_live(WrittenTrack& track, av::Frame picture, const FrameInfo& info) {
    track.held.reset(av_frame_clone(picture.get()));
    if (!track.held)
        throw std::bad_alloc();
    track.held_info = info;
    picture->pict_type = std::exchange(track.begins_group, false) ? AV_PICTURE_TYPE_I : AV_PICTURE_TYPE_NONE;
    encode(track, std::move(picture), info, 0);
}

void StreamWriter::write(TrackRole role, ImageView<const std::uint8_t> rgb, const FrameInfo& info, std::size_t tile) {
    WrittenTrack& track = state_->start_picture(role, info, tile);
    state_->take(track, track.encoder.convert(rgb), info);
}

void StreamWriter::write_pq(TrackRole role, ImageView<const float> rgb, const FrameInfo& info, std::size_t tile) {
    WrittenTrack& track = state_->start_picture(role, info, tile);
    state_->take(track, track.encoder.convert_pq(rgb), info);
}

void StreamWriter::write_depth(TrackRole role, ImageView<const float> depth_m, const FrameInfo& info,
                               std::size_t tile) {
    WrittenTrack& track = state_->start_picture(role, info, tile);
    FrameInfo counted = info;
    av::Frame picture = track.encoder.convert(depth_m, *counted.depth_code);
    state_->take(track, std::move(picture), counted);
}

void StreamWriter::begin_group() {
    for (const auto& track : state_->tracks)
        track->begins_group = true;
}

void StreamWriter::set_crf(TrackRole role, double crf) {
    state_->track_of(role, 0).encoder.set_crf(crf);
}

void StreamWriter::set_size(TrackRole role, int width, int height) {
    WrittenTrack& track = state_->track_of(role, 0);
    if (!state_->settings.live)
        throw WorkError(expected_found(state_->target, "a live stream, whose tracks may change their size", "another"));
    track.encoder.set_size(width, height);
    track.held.reset();
    track.begins_group = true;
}

void StreamWriter::flush() {
    State& s = *state_;
    s.check(av_interleaved_write_frame(s.format.get(), nullptr), "writing what waits for other tracks");
    s.check(av_write_frame(s.format.get(), nullptr), "ending a cluster");
    avio_flush(s.output->io());
    s.check(0, "writing");
}

void StreamWriter::finish() {
    State& s = *state_;
    if (s.over)
        throw WorkError(s.target + ": has ended already");
    s.end_tracks(true);
    for (const auto& track : s.tracks)
        if (s.settings.pictures > 0 && track->pictures != s.settings.pictures)
            throw WorkError(expected_found(s.target + ": " + track_name(track->role),
                                           std::to_string(s.settings.pictures) + " pictures",
                                           std::to_string(track->pictures)));
    s.output->finish();
}

std::vector<std::int64_t> StreamWriter::bytes() const {
    std::vector<std::int64_t> counts;
    for (const auto& track : state_->tracks)
        counts.push_back(track->bytes);
    return counts;
}

bool StreamWriter::tags_sphere() const {
    return state_->tags_sphere();
}

const std::string& StreamWriter::unfinished_file() const {
    return state_->output->unfinished_file();
}

}  // namespace equistream
