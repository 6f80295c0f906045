#include "matroska_file.h"
#include "source.h"
#include "spatial_boxes.h"
#include "track_decoder.h"
#include "truncation.h"

#include <equistream/error.h>
#include <equistream/stream.h>

#include <algorithm>
#include <deque>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <optional>
#include <string_view>

namespace equistream {

namespace {

/// Pictures that each tile's decoder works on at once; others, as many as there are cores.
constexpr int threads_of_tiles = 2;

bool is_video(const AVStream& stream) {
    return stream.codecpar->codec_type == AVMEDIA_TYPE_VIDEO && (stream.disposition & AV_DISPOSITION_ATTACHED_PIC) == 0;
}

bool can_go_back(const AVFormatContext& format) {
    return format.pb != nullptr && (format.pb->seekable & AVIO_SEEKABLE_NORMAL) != 0;
}

bool comes_at_its_own_pace(const std::string& source, const AVFormatContext& format) {
    return is_url(source) && !is_pipe(source) && !can_go_back(format);
}

/// Until a track's pictures say: as the container calls it; where that keeps no names, main comes first.
TrackRole assumed_role(const AVStream& stream, std::size_t position) {
    if (position == 0)
        return TrackRole::main;
    const AVDictionaryEntry* title = av_dict_get(stream.metadata, "title", nullptr, 0);
    if (title == nullptr)
        title = av_dict_get(stream.metadata, "handler_name", nullptr, 0);
    for (int role = 1; title != nullptr && role < track_role_count; ++role)
        if (track_name(static_cast<TrackRole>(role)) == std::string_view(title->value))
            return static_cast<TrackRole>(role);
    return TrackRole::small;
}

/// Units of H.264 and H.265 behind four bytes of length each, most significant first, as our own files have them.
bool unit_lengths_add_up(std::span<const std::uint8_t> packet) {
    constexpr std::size_t prefix = 4;
    while (packet.size() >= prefix) {
        std::size_t length = 0;
        for (const std::uint8_t byte : packet.first(prefix))
            length = length << 8 | byte;
        if (length > packet.size() - prefix)
            return false;
        packet = packet.subspan(prefix + length);
    }
    return packet.empty();
}

bool is_mp4(const AVFormatContext& format) {
    return std::string_view(format.iformat->name).starts_with("mov");
}

/// Of an MP4 file, to look at its boxes; elsewhere the movie's header has gone by.
std::optional<std::ifstream> open_mp4(const std::string& source, const AVFormatContext& format) {
    std::error_code error;
    if (is_url(source) || !is_mp4(format) || !std::filesystem::is_regular_file(source, error))
        return std::nullopt;
    return std::ifstream(source, std::ios::binary);
}

struct ReadTrack {
    ReadTrack(const AVStream& stream, TrackRole role, const std::string& source, const StreamReadOptions& options,
              int threads)
        : index(stream.index), decoder(stream, role, source, options, threads) {}

    int index;
    TrackDecoder decoder;
    std::optional<double> newest_s;  ///< by the track's own clock
    av::Packet held;                 ///< the newest packet: only a next one shows that it was not cut short
};

}  // namespace

struct StreamReader::State {
    State(const std::string& source_name, const StreamReadOptions& read_options);

    bool read_packet();
    bool next_packet();
    void take_in(ReadTrack& track, AVPacket& packet);
    bool may_be_cut(const ReadTrack& track) const;
    bool is_tile(const ReadTrack& track) const;
    bool begins_again() const;
    bool is_length_known() const;
    void end();
    std::optional<DecodedPicture> take();
    void refresh_summaries();

    std::string source;
    StreamReadOptions options;
    Source format;
    bool holds_back;  ///< files only: on a live stream it would cost a picture's time
    bool is_live = false;
    std::int64_t missing_bytes = 0;  ///< of the file's end
    bool has_fragments = false;      ///< of an MP4
    std::string container;
    std::vector<std::unique_ptr<ReadTrack>> tracks;
    std::vector<StreamTrackSummary> summaries;
    av::Packet packet = av::make_packet();
    std::deque<av::Packet> searched;  ///< by a seek, to come before what is read
    std::optional<double> origin_s;   ///< when main's first picture is shown
    std::string read_error;
    std::string truncation;
    bool ended = false;
};

StreamReader::State::State(const std::string& source_name, const StreamReadOptions& read_options)
    : source(source_name), options(read_options), format(source, options), holds_back(!is_url(source_name)) {
    container = format->iformat->long_name;
    is_live = comes_at_its_own_pace(source, *format);
    if (!is_url(source) && !options.read)
        missing_bytes = missing_matroska_bytes(source);
    const int threads = has_tiles(*format) ? threads_of_tiles : 0;
    std::map<std::uint32_t, SpatialTags> tags;
    if (std::optional<std::ifstream> mp4 = open_mp4(source, *format)) {
        tags = read_spatial_tags(*mp4);
        mp4->clear();
        has_fragments = is_in_fragments(*mp4);
    }
    for (unsigned i = 0; i < format->nb_streams; ++i) {
        AVStream& stream = *format->streams[i];
        if (!is_video(stream) || tracks.size() == max_stream_tracks) {
            stream.discard = AVDISCARD_ALL;
            continue;
        }
        av::forget_unknown_colours(*stream.codecpar);
        tracks.push_back(
            std::make_unique<ReadTrack>(stream, assumed_role(stream, tracks.size()), source, options, threads));
        if (const auto said = tags.find(std::uint32_t(stream.id)); said != tags.end())
            tracks.back()->decoder.take_tags(said->second);
        if (holds_back)
            tracks.back()->held = av::make_packet();
        else
            tracks.back()->decoder.join_anywhere();
        if (options.read)
            tracks.back()->decoder.forgive_gaps();
    }
    if (tracks.empty() && !format.problem().empty())
        throw WorkError(source + ": " + format.problem());
    if (tracks.empty())
        throw InputError(expected_found(source, "a video track", "none"));
    refresh_summaries();
    // A server sends tiles while they are looked at.
    for (const auto& track : tracks)
        if (is_tile(*track))
            track->decoder.be_tile(!holds_back);
}

bool StreamReader::State::is_tile(const ReadTrack& track) const {
    const TrackRole role = track.decoder.summary().role;
    return may_be_tiled(role) &&
           std::ranges::count_if(tracks, [&](const auto& other) { return other->decoder.summary().role == role; }) > 1;
}

void StreamReader::State::take_in(ReadTrack& track, AVPacket& incoming) {
    if (const auto time_s = track.decoder.time_of_s(incoming.pts))
        track.newest_s = std::max(track.newest_s.value_or(*time_s), *time_s);
    if (!holds_back)
        return track.decoder.decode(incoming);
    if (track.held->size > 0)
        track.decoder.decode(*track.held);
    av_packet_unref(track.held.get());
    av_packet_move_ref(track.held.get(), &incoming);
}

bool StreamReader::State::next_packet() {
    if (!searched.empty()) {
        packet = std::move(searched.front());
        searched.pop_front();
        return true;
    }
    format.begin_waiting();
    const int code = av::read_packet(*format, *packet);
    if (code < 0 && code != AVERROR_EOF)
        read_error = av::error_text(code);
    return code >= 0;
}

bool StreamReader::State::read_packet() {
    if (!next_packet())
        return false;
    const auto track = std::ranges::find(tracks, packet->stream_index, [](const auto& one) { return one->index; });
    if (track != tracks.end() && !(*track)->decoder.is_left_out()) {
        if ((packet->flags & AV_PKT_FLAG_CORRUPT) != 0)
            (*track)->decoder.count_damaged_packet();
        else
            take_in(**track, *packet);
    }
    av_packet_unref(packet.get());
    return true;
}

/// Whether the last packet of a track may lack its end. Where units carry their lengths (mp4, mkv) these must add up;
/// where start codes part them nothing tells.
bool StreamReader::State::may_be_cut(const ReadTrack& track) const {
    const AVCodecParameters& parameters = *format->streams[track.index]->codecpar;
    if (parameters.extradata_size > 0 && parameters.extradata[0] == 1)
        return !unit_lengths_add_up({track.held->data, static_cast<std::size_t>(track.held->size)});
    return true;
}

bool StreamReader::State::begins_again() const {
    return std::ranges::any_of(tracks, [](const auto& track) { return track->decoder.begins_again(); });
}

/// libav guesses by the bit rate. Of an mp4 in fragments it knows those that it has read so far. At an address only a
/// header without pictures tells that there are fragments.
bool StreamReader::State::is_length_known() const {
    const bool is_guessed = format->duration_estimation_method == AVFMT_DURATION_FROM_BITRATE;
    const bool is_partly_known =
        has_fragments || (is_mp4(*format) && format->streams[tracks.front()->index]->nb_frames == 0);
    return can_go_back(*format) && !is_guessed && !is_partly_known && missing_bytes == 0 && format->duration > 0;
}

void StreamReader::State::end() {
    for (const auto& track : tracks) {
        if (track->decoder.is_left_out())
            continue;
        if (track->held && track->held->size > 0)
            track->decoder.decode(*track->held, may_be_cut(*track));
        track->decoder.drain();
    }
    ended = true;
}

std::optional<DecodedPicture> StreamReader::State::take() {
    for (;;) {
        // At the end each track has several left: they come side by side, so that nobody has to hold one track's.
        const auto earliest = std::ranges::min_element(tracks, {}, [](const auto& track) {
            return track->decoder.next_time_s().value_or(std::numeric_limits<double>::infinity());
        });
        TrackDecoder& decoder = (*earliest)->decoder;
        auto picture = decoder.take(options);
        if (!picture)
            return std::nullopt;
        picture->track = std::size_t(earliest - tracks.begin());
        if (!origin_s && earliest == tracks.begin())
            origin_s = picture->time_s;
        if (picture->time_s)
            picture->time_s = origin_s ? std::optional(*picture->time_s - *origin_s) : std::nullopt;
        const bool is_wanted = !decoder.known_role() || options.wants(*decoder.known_role());
        if (!is_wanted) {
            decoder.leave_out();
            format->streams[(*earliest)->index]->discard = AVDISCARD_ALL;
        }
        summaries[picture->track] = decoder.summary();
        if (is_wanted)
            return picture;
    }
}

void StreamReader::State::refresh_summaries() {
    summaries.clear();
    for (const auto& track : tracks)
        summaries.push_back(track->decoder.summary());
}

StreamReader::StreamReader(const std::string& source, const StreamReadOptions& options)
    : state_(std::make_unique<State>(source, options)) {}

StreamReader::~StreamReader() = default;

void StreamReader::leave_out(TrackRoles roles) {
    state_->options.left_out |= roles;
}

std::optional<DecodedPicture> StreamReader::next() {
    State& s = *state_;
    for (;;) {
        if (auto picture = s.take())
            return picture;
        if (s.ended)
            break;
        if (s.begins_again() || !s.read_packet())
            s.end();
    }
    std::vector<TrackTally> tallies;
    for (const auto& track : s.tracks)
        tallies.push_back(track->decoder.tally());
    const std::int64_t announced = s.format->streams[s.tracks.front()->index]->nb_frames;
    s.truncation = describe_truncation({s.source, s.read_error, announced, s.missing_bytes}, tallies);
    if (!s.format.problem().empty())
        s.truncation = (s.truncation.empty() ? s.source + ": " : s.truncation + "; ") + s.format.problem();
    return std::nullopt;
}

const std::vector<StreamTrackSummary>& StreamReader::tracks() const {
    return state_->summaries;
}

const std::string& StreamReader::container() const {
    return state_->container;
}

bool StreamReader::seek(double seconds) {
    State& s = *state_;
    if (!s.origin_s || !can_go_back(*s.format))
        return false;
    std::vector<int> wanted;
    for (const auto& track : s.tracks)
        if (!track->decoder.is_left_out())
            wanted.push_back(track->index);
    auto packets = find_packets(*s.format, wanted, *s.origin_s + seconds);
    if (!packets)
        return false;
    s.searched = std::move(*packets);
    for (const auto& track : s.tracks) {
        track->decoder.jump();
        track->newest_s.reset();
        if (track->held)
            av_packet_unref(track->held.get());
    }
    s.ended = false;
    s.read_error.clear();
    s.truncation.clear();
    return true;
}

std::optional<double> StreamReader::newest_s(std::size_t track) const {
    const auto& newest_s = state_->tracks[track]->newest_s;
    return newest_s && state_->origin_s ? std::optional(*newest_s - *state_->origin_s) : std::nullopt;
}

std::int64_t StreamReader::position() const {
    const AVIOContext* file = state_->format->pb;
    return file == nullptr ? 0 : std::max<std::int64_t>(0, avio_tell(const_cast<AVIOContext*>(file)));
}

std::optional<double> StreamReader::seconds() const {
    return state_->is_length_known() ? std::optional(double(state_->format->duration) / AV_TIME_BASE) : std::nullopt;
}

bool StreamReader::is_live() const {
    return state_->is_live;
}

const std::string& StreamReader::truncation() const {
    return state_->truncation;
}

}  // namespace equistream
