#pragma once
/// Streams: colour tracks of H.264 or H.265 whose pictures carry their own FrameInfo (SEI user data), in any
/// container libavformat knows. Written front to back, so a file and a socket carry the same bytes. The payload's
/// table is docs/stream-format.md. Errors name the file or URL. One object, one thread.
#include <equistream/frame.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace equistream {

/// What a track carries. Values are part of the format; new ones are only appended.
enum class TrackRole : std::uint8_t { main = 0, small = 1 };

const char* track_name(TrackRole role);  ///< "main", "small"

/// FrameInfo <-> SEI payload (UUID included). decode returns nothing for a payload that is not ours and throws
/// WorkError for one that is ours but damaged; fields appended by later versions are skipped.
std::vector<std::uint8_t> encode_frame_info(TrackRole role, const FrameInfo& info);
struct TaggedFrameInfo {
    TrackRole role = TrackRole::main;
    FrameInfo info;
};
std::optional<TaggedFrameInfo> decode_frame_info(std::span<const std::uint8_t> payload);

enum class Codec { h264, h265 };

struct TrackSettings {
    TrackRole role = TrackRole::main;
    int width = 0;   ///< even
    int height = 0;  ///< even
};

struct StreamSettings {
    Codec codec = Codec::h264;
    int crf = 16;
    std::string preset = "medium";
    int gop = 30;  ///< pictures from one key frame to the next
    double frames_per_second = 30;
    std::vector<TrackSettings> tracks;
    std::string scene;         ///< container title
    bool full_sphere = false;  ///< tag the main track as equirectangular video for ordinary 360 players
};

/// Encodes display-referred sRGB pictures (8-bit RGB) to `target` (a path, whose extension picks the container, or a
/// URL).
class StreamWriter {
public:
    StreamWriter(const std::string& target, const StreamSettings& settings);
    ~StreamWriter();
    StreamWriter(const StreamWriter&) = delete;
    StreamWriter& operator=(const StreamWriter&) = delete;

    /// Pictures of one track in display order; tracks interleave as they come.
    void write(TrackRole role, ImageView<const std::uint8_t> rgb, const FrameInfo& info);
    /// Flushes the encoders and ends the file; throws WorkError if the disk was full, and so on.
    void finish();
    /// Coded bytes so far, per track in the order of StreamSettings::tracks.
    std::vector<std::int64_t> bytes() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// One decoded picture: 8-bit display-referred sRGB, RGB interleaved.
struct DecodedPicture {
    TrackRole role = TrackRole::main;
    std::optional<FrameInfo> info;  ///< absent in foreign videos
    ByteImage rgb;
    double decode_ms = 0;   ///< decoder's time for this picture
    double convert_ms = 0;  ///< YUV to RGB
};

struct StreamTrackSummary {
    TrackRole role = TrackRole::main;
    std::string codec;
    int width = 0;
    int height = 0;
    double frames_per_second = 0;
};

class StreamReader {
public:
    explicit StreamReader(const std::string& source);
    ~StreamReader();
    StreamReader(const StreamReader&) = delete;
    StreamReader& operator=(const StreamReader&) = delete;

    const std::vector<StreamTrackSummary>& tracks() const;
    /// The next picture of any track, in presentation order within each; nothing at the end.
    std::optional<DecodedPicture> next();
    /// After the end: empty, or one line on how the stream ended early ("cut after frame 5 ...").
    const std::string& truncation() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace equistream
