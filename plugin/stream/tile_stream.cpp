#include "libav.h"
#include "source.h"

#include <equistream/error.h>
#include <equistream/stream.h>
#include <equistream/tile_stream.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>
#include <vector>

namespace equistream {

namespace {

/// Of one tile, since its last key frame.
constexpr std::size_t max_kept_packets = max_group_pictures;
constexpr std::int64_t max_kept_bytes = 8 << 20;
/// Of a track.
constexpr std::int64_t max_pictures = 1'000'000'000;

InputError not_of_one_sphere(const std::string& file, const std::string& found) {
    return InputError(expected_found(file, "tiles that are the parts of one sphere", found));
}

/// That main is a sphere, for ordinary players.
void copy_side_data(const AVStream& from, AVStream& to) {
    for (int i = 0; i < from.nb_side_data; ++i) {
        const AVPacketSideData& data = from.side_data[i];
        std::uint8_t* const copy = av_stream_new_side_data(&to, data.type, data.size);
        if (copy == nullptr)
            throw std::bad_alloc();
        std::copy_n(data.data, data.size, copy);
    }
}

}  // namespace

std::optional<TileRecording> open_tiles(const std::string& file, const std::function<bool()>& interrupted) {
    const StreamReadOptions options{.rgb = false, .interrupted = interrupted};
    if (!has_tiles(*Source(file, options)))
        return std::nullopt;
    StreamReader reader(file, options);
    TileRecording recording{
        file, {}, {}, std::vector<std::optional<int>>(reader.tracks().size()), read_send_times(file, interrupted)};
    std::vector<bool> seen(reader.tracks().size());
    bool has_main = false;
    std::optional<TilePart> first;
    while (std::ranges::count(seen, true) < std::ssize(seen)) {
        const std::optional<DecodedPicture> picture = reader.next();
        if (!picture)
            throw InputError(expected_found(file, "pictures of all its tiles", "some tiles without any"));
        if (seen[picture->track] || !picture->info)
            continue;
        seen[picture->track] = true;
        if (picture->role == TrackRole::main) {
            if (picture->info->lock != AxisLock::world)
                throw not_of_one_sphere(file, "spheres whose axes turn");
            recording.first = *picture->info;
            has_main = true;
        }
        if (!may_be_tiled(picture->role))
            continue;
        const auto* tile = std::get_if<EquirectCamera>(&picture->info->camera);
        if (tile == nullptr)
            throw not_of_one_sphere(file, "a flat view");
        const std::optional<TilePart> part = tile_part(*tile);
        if (!part)
            throw not_of_one_sphere(file, "one of " + size_text(tile->width, tile->height) + " that fits no grid");
        if (first && !part->is_of_same_sphere(*first))
            throw not_of_one_sphere(file, "tiles of other sizes");
        first = first.value_or(*part);
        recording.tiles[picture->track] = part->number();
    }
    if (!has_main)
        throw InputError(expected_found(file, "a sphere around its tiles", "none"));
    if (!first)
        throw not_of_one_sphere(file, "none");
    recording.grid = first->grid;
    return recording;
}

struct TileSender::State {
    explicit State(const TileRecording& recording_of);

    /// One of the file's video tracks.
    struct Track {
        int stream = 0;  ///< of the file
        std::optional<int> tile;
        std::vector<av::Packet> kept{};  ///< of a tile, since its last key frame, in their order
        std::int64_t kept_bytes = 0;
        bool has_lost = false;  ///< some of these were too many to be kept
        std::int64_t read = 0;  ///< packets, by which they are numbered
        std::int64_t sent = 0;  ///< the number of the last one that was sent; 0: none was
    };

    /// Read, and to be sent at its time.
    struct Waiting {
        double due_s = 0;
        av::Packet packet;
    };

    void send_next(const std::set<int>& looked_at);
    void skip_to(std::int64_t start);
    void write_header();
    void read_ahead();
    void wait_in_line();
    Track& track_of(const AVPacket& packet);
    double in_file_s(const AVPacket& packet) const;
    double due_s(const AVPacket& packet) const;
    void keep(Track& track, av::Packet packet);
    void send(Track& track, const AVPacket& packet);
    void send_kept(Track& track);
    void require(int code, const char* doing) const;
    static int take_bytes(void* self, std::uint8_t* bytes, int count);

    const TileRecording& recording;
    StreamReadOptions options;
    Source source;
    av::Io io;  ///< outlives the muxer
    av::Muxer muxer;
    std::vector<Track> tracks;  ///< as the muxer's
    av::Packet ahead;           ///< the next of the file; null: it has ended
    std::deque<Waiting> line;   ///< by time, then in the file's order: what is due before `ahead` can be
    double last_due_s = 0;      ///< of what was sent last
    bool has_header = false, over = false;
    std::string out;  ///< the muxer's bytes, on their way
};

TileSender::State::State(const TileRecording& recording_of)
    : recording(recording_of), source(recording.file, options, {}, true) {
    AVFormatContext* opened = nullptr;
    if (avformat_alloc_output_context2(&opened, nullptr, "matroska", nullptr) < 0)
        throw InputError(recording.file + ": this libavformat cannot write matroska");
    muxer.reset(opened);
    constexpr int buffer_bytes = 1 << 16;
    auto* buffer = static_cast<unsigned char*>(av_malloc(buffer_bytes));
    io.reset(buffer ? avio_alloc_context(buffer, buffer_bytes, 1, this, nullptr, &take_bytes, nullptr) : nullptr);
    if (io == nullptr) {
        av_free(buffer);
        throw std::bad_alloc();
    }
    muxer->pb = io.get();
    muxer->pb->seekable = 0;
    muxer->flags |= AVFMT_FLAG_BITEXACT;
    muxer->avoid_negative_ts = AVFMT_AVOID_NEG_TS_DISABLED;
    av_dict_copy(&muxer->metadata, source->metadata, 0);
    for (unsigned i = 0; i < source->nb_streams; ++i) {
        AVStream& from = *source->streams[i];
        const bool is_cover = (from.disposition & AV_DISPOSITION_ATTACHED_PIC) != 0;  // StreamReader has no track of it
        if (from.codecpar->codec_type != AVMEDIA_TYPE_VIDEO || is_cover || tracks.size() == recording.tiles.size())
            continue;
        AVStream* to = avformat_new_stream(muxer.get(), nullptr);
        if (to == nullptr || avcodec_parameters_copy(to->codecpar, from.codecpar) < 0)
            throw std::bad_alloc();
        to->codecpar->codec_tag = 0;
        to->time_base = from.time_base;
        to->avg_frame_rate = from.avg_frame_rate;
        to->disposition = from.disposition;
        av_dict_copy(&to->metadata, from.metadata, 0);
        copy_side_data(from, *to);
        tracks.push_back({int(i), recording.tiles[tracks.size()]});
    }
    read_ahead();
    wait_in_line();
}

int TileSender::State::take_bytes(void* self, std::uint8_t* bytes, int count) {
    try {  // nothing may be thrown through libav
        static_cast<State*>(self)->out.append(reinterpret_cast<const char*>(bytes), std::size_t(count));
        return count;
    } catch (const std::exception&) {
        return AVERROR(ENOMEM);
    }
}

void TileSender::State::require(int code, const char* doing) const {
    if (code < 0)
        throw WorkError(recording.file + ": " + doing + ": " + av::error_text(code));
}

double TileSender::State::in_file_s(const AVPacket& packet) const {
    const std::vector<DueBytes>& parts = recording.times.parts;
    const auto part = std::ranges::upper_bound(parts, packet.pos, {}, &DueBytes::end);
    return (part == parts.end() ? parts.back() : *part).time_s;
}

/// In an mp4 a group of one track lies before that of the next: what lies in front of others may wait.
double TileSender::State::due_s(const AVPacket& packet) const {
    const std::vector<DuePacket>& packets = recording.times.packets;
    const auto placed = std::ranges::lower_bound(packets, packet.pos, {}, &DuePacket::start);
    return std::max(in_file_s(packet), placed == packets.end() ? 0 : placed->time_s);
}

TileSender::State::Track& TileSender::State::track_of(const AVPacket& packet) {
    return *std::ranges::find(tracks, packet.stream_index, &Track::stream);
}

void TileSender::State::read_ahead() {
    ahead = av::make_packet();
    do {
        av_packet_unref(ahead.get());
        if (av::read_packet(*source, *ahead) < 0) {
            ahead.reset();
            return;
        }
    } while (ahead->pts == AV_NOPTS_VALUE ||
             std::ranges::find(tracks, ahead->stream_index, &Track::stream) == tracks.end());
}

/// Until none that is still in the file can be due earlier.
void TileSender::State::wait_in_line() {
    while (ahead && (line.empty() || in_file_s(*ahead) <= line.front().due_s)) {
        const double time_s = due_s(*ahead);
        line.insert(std::ranges::upper_bound(line, time_s, {}, &Waiting::due_s), {time_s, std::move(ahead)});
        read_ahead();
    }
}

void TileSender::State::write_header() {
    require(avformat_write_header(muxer.get(), nullptr), "writing the header");
    avio_flush(muxer->pb);
    has_header = true;
}

void TileSender::State::keep(Track& track, av::Packet packet) {
    ++track.read;
    const bool is_key = (packet->flags & AV_PKT_FLAG_KEY) != 0;
    const bool is_full = track.kept.size() == max_kept_packets || track.kept_bytes + packet->size > max_kept_bytes;
    if (is_key || is_full) {
        track.has_lost = !is_key && (track.has_lost || track.sent < track.read - 1);
        track.kept.clear();
        track.kept_bytes = 0;
    }
    track.kept_bytes += packet->size;
    track.kept.push_back(std::move(packet));
}

void TileSender::State::send(Track& track, const AVPacket& packet) {
    const av::Packet copy(av_packet_clone(&packet));
    if (copy == nullptr)
        throw std::bad_alloc();
    const AVStream& to = *muxer->streams[&track - tracks.data()];
    copy->stream_index = to.index;
    copy->pos = -1;
    av_packet_rescale_ts(copy.get(), source->streams[track.stream]->time_base, to.time_base);
    // Matroska keeps no times of decoding, and readers of it do not know all of them: any that rise will do.
    copy->dts = ++track.sent - max_pictures;
    require(av_write_frame(muxer.get(), copy.get()), "sending a packet");
}

/// What a tile's viewer lacks. Without all of them since the key frame none can be shown.
void TileSender::State::send_kept(Track& track) {
    if (track.has_lost)
        return;
    // The last kept is the last read.
    const auto kept = std::int64_t(track.kept.size());
    const std::int64_t lacking = std::min(track.read - track.sent, kept);
    track.sent = track.read - lacking;
    for (std::int64_t i = kept - lacking; i < kept; ++i)
        send(track, *track.kept[std::size_t(i)]);
}

TileSender::TileSender(const TileRecording& recording) : state_(std::make_unique<State>(recording)) {}

TileSender::~TileSender() = default;

std::optional<double> TileSender::due_s() const {
    const State& s = *state_;
    if (!s.has_header)
        return 0;
    if (s.over)
        return std::nullopt;
    return s.line.empty() ? s.last_due_s : s.line.front().due_s;
}

void TileSender::next(const std::set<int>& looked_at, std::string& bytes) {
    state_->send_next(looked_at);
    bytes += std::exchange(state_->out, {});
}

void TileSender::skip_to_group(double time_s) {
    const Moment* const group = newest_group(state_->recording.times.moments, time_s);
    if (group != nullptr && state_->has_header)
        state_->skip_to(group->start);
}

/// Tiles are kept as if nobody looked at them.
void TileSender::State::skip_to(std::int64_t start) {
    while (!line.empty() && line.front().packet->pos < start) {
        av::Packet packet = std::move(line.front().packet);
        line.pop_front();
        if (Track& track = track_of(*packet); track.tile)
            keep(track, std::move(packet));
        wait_in_line();
    }
}

void TileSender::State::send_next(const std::set<int>& looked_at) {
    if (!has_header)
        return write_header();
    if (line.empty()) {
        require(av_write_trailer(muxer.get()), "ending");
        over = true;
        return;
    }
    last_due_s = line.front().due_s;
    std::vector<av::Packet> others;
    while (!line.empty() && line.front().due_s <= last_due_s + 1e-6) {
        av::Packet packet = std::move(line.front().packet);
        line.pop_front();
        if (Track& track = track_of(*packet); track.tile)
            keep(track, std::move(packet));
        else
            others.push_back(std::move(packet));
        wait_in_line();
    }
    // Tiles go first: whoever has a moment's main picture knows by then which tiles go with it.
    for (Track& track : tracks)
        if (track.tile && (track.sent == 0 || looked_at.contains(*track.tile)))
            send_kept(track);
    for (const av::Packet& packet : others)
        send(track_of(*packet), *packet);
    require(av_write_frame(muxer.get(), nullptr), "ending a cluster");
    avio_flush(muxer->pb);
}

}  // namespace equistream
