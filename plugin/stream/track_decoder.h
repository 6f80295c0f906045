#pragma once
/// One track of a stream being read: packets in, checked pictures out, and the tally of what came and what is missing.
#include "picture_converter.h"
#include "picture_decoding.h"
#include "spatial_boxes.h"

#include <equistream/depth_code.h>
#include <equistream/stream.h>

#include <deque>

namespace equistream {

/// What a track's pictures said of themselves, to tell a whole track from a cut one. Counts begin anew with a jump.
struct TrackTally {
    TrackRole role = TrackRole::main;
    std::int64_t pictures = 0;    ///< delivered
    std::int64_t missing = 0;     ///< gaps in the ordinals
    std::int64_t unreadable = 0;  ///< packets or pictures that arrived damaged
    std::uint32_t expected = 0;   ///< next ordinal
    std::uint32_t count = 0;      ///< the length the track declares, 0 while unknown
    std::optional<std::int64_t> last_index;
    bool ours = false;
    bool left_out = false;  ///< not wanted
    bool jumped = false;    ///< not all before the last picture was asked for
    bool partial = false;   ///< comes while it is looked at
    bool served = false;    ///< by a server, which leaves out what its viewer has no time for

    bool whole() const {
        return left_out || partial || (ours && count > 0 && expected >= count && (missing == 0 || served));
    }
};

class TrackDecoder {
public:
    /// Throws InputError for a codec that is not there or a size beyond image.h's limits. `threads`: pictures that are
    /// worked on at once, 0 as many as there are cores.
    TrackDecoder(const AVStream& stream, TrackRole assumed_role, const std::string& source,
                 const StreamReadOptions& options, int threads);
    TrackDecoder(const TrackDecoder&) = delete;
    TrackDecoder& operator=(const TrackDecoder&) = delete;

    /// `suspect`: the last packet of a track that may have been cut short.
    void decode(const AVPacket& packet, bool suspect = false);
    void drain();
    /// What the file's vexu box says of the track; what libavformat found goes before it.
    void take_tags(const SpatialTags& tags);
    /// A key frame comes next, from anywhere in the track: what is held goes, what lies between is not missing.
    void jump();
    /// When the next picture that is ready is shown; nothing where none is, the past where it does not say.
    std::optional<double> next_time_s() const;
    /// By the track's own clock; nothing for AV_NOPTS_VALUE.
    std::optional<double> time_of_s(std::int64_t timestamp) const;
    /// The next picture that is ready, given as `options` ask.
    std::optional<DecodedPicture> take(const StreamReadOptions& options);
    /// What it holds, once a picture of ours has said so.
    std::optional<TrackRole> known_role() const { return tally_.ours ? std::optional(tally_.role) : std::nullopt; }
    /// Nobody wants this track: what is left of it is not missing.
    void leave_out();
    /// A whole track has been followed by its own beginning, which is left out, as is what comes behind it.
    bool begins_again() const { return begins_again_; }
    bool is_left_out() const { return tally_.left_out; }

    const TrackTally& tally() const { return tally_; }
    const StreamTrackSummary& summary() const { return summary_; }
    void count_damaged_packet() { ++tally_.unreadable; }
    /// Joined in the middle (live): what was before the first picture is not missing.
    void join_anywhere() { joined_anywhere_ = true; }
    /// A server of ours sends it.
    void forgive_gaps() { tally_.served = true; }
    /// Its pictures carry frame data with their key frames alone. If it comes and goes, as eyes turn, none is missing.
    void be_tile(bool comes_and_goes) {
        is_tile_ = true;
        tally_.partial = comes_and_goes;
    }

private:
    struct Ready {
        av::Frame frame;
        std::optional<TaggedFrameInfo> tagged;
        std::string_view decoder;
        double decode_ms;
        bool suspect;
    };
    void send(const AVPacket* packet);
    void receive();
    void accept(av::Frame frame);
    void give_colour(av::Frame frame, const StreamReadOptions& options, DecodedPicture& picture);
    void give_depth(const AVFrame& frame, DecodedPicture& picture);
    void note(const TaggedFrameInfo& tagged);
    bool is_repetition(const TrackPosition& position);
    std::optional<TaggedFrameInfo> of_group(const AVFrame& frame) const;

    std::string source_;
    const AVStream& stream_;
    HardwareDecoding hardware_;
    DecoderCallbacks callbacks_;
    av::Codec codec_;
    PictureScaler to_rgb_{AV_PIX_FMT_RGB24}, to_pq_{our_pq};
    std::unique_ptr<DepthCode> depth_code_;
    TrackTally tally_;
    StreamTrackSummary summary_;
    std::deque<Ready> ready_;
    double busy_ms_ = 0;
    TrackPosition accepted_{};  ///< next ordinal, and the highest count, of the pictures that are ready or were given
    bool begins_again_ = false;
    bool joined_anywhere_ = false;
    bool is_tile_ = false;
    struct Group {
        TaggedFrameInfo first;
        double time_s;
    };
    std::optional<Group> group_;     ///< of a tile: what its last key frame said, and when that is shown
    bool jumping_ = false;           ///< no picture was given since
    bool version_is_known_ = false;  ///< a picture's frame data could be read
};

}  // namespace equistream
