#pragma once
/// Streams: colour and depth tracks of H.264 or H.265 whose pictures carry their own FrameInfo (SEI user data), in any
/// container libavformat knows. Written front to back, so a file and a socket carry the same bytes. The payload's
/// table is docs/stream-format.md. Errors name the file or URL. One object, one thread.
#include <equistream/frame.h>
#include <equistream/image.h>
#include <equistream/yuv.h>

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace equistream {

/// What a track carries. Values are part of the format; new ones are only appended.
enum class TrackRole : std::uint8_t {
    main = 0,
    small = 1,          ///< the small second-eye view
    depth = 2,          ///< main's radial depth
    hidden = 3,         ///< the next surface behind main's, along the same rays
    hidden_depth = 4,   ///< hidden's radial depth
    patches = 5,        ///< what an eye of the head box uncovers, packed in an atlas
    patches_depth = 6,  ///< the atlas's radial depth, each patch's from its own origin
    reflections = 7,    ///< main's mirrors and glass: how far away what they show is, no surface where there are none
    /// The part of a denser sphere that someone looks at (window.h); main is the sphere around it. Several tracks of
    /// this role are tiles: each a window at a place of its own, together the denser sphere.
    window = 8,
    window_depth = 9,         ///< window's radial depth
    window_reflections = 10,  ///< window's mirrors and glass
};
inline constexpr int track_role_count = 11;
/// Of one stream, tiles counted singly: what Matroska takes.
inline constexpr std::size_t max_stream_tracks = 127;
using TrackRoles = std::bitset<track_role_count>;  ///< by value

const char* track_name(TrackRole role);  ///< "main", "small", "depth", "hidden", "hidden-depth", ...

/// Whether pictures of this role are distances, coded by a DepthCode (depth_code.h).
bool is_depth(TrackRole role);
/// Of colour tracks: the role of their depth, where there is one (all but small).
std::optional<TrackRole> depth_role_of(TrackRole colour);
/// Of main and window: the role of their mirrors and glass.
std::optional<TrackRole> reflections_role_of(TrackRole colour);
/// Whether the role is the depth of main or window, which may be coded at half the columns and rows.
bool may_be_halved(TrackRole role);
/// Whether the role is of mirrors and glass.
bool is_reflections(TrackRole role);
/// Whether a stream may have several tracks of this role, which are tiles.
bool may_be_tiled(TrackRole role);

/// Where a picture stands in its track, so that a cut or a gap shows whatever the container.
struct TrackPosition {
    std::uint32_t ordinal = 0;  ///< 0 for the track's first picture
    std::uint32_t count = 0;    ///< pictures in the track, 0 while unknown; the track's last picture always says it
};

/// FrameInfo <-> SEI payload (UUID included). encode throws InputError for a name above 255 bytes. decode returns
/// nothing for a payload that is not ours, throws WorkError for one that is ours but damaged and InputError for one of
/// another layout, of a version to come; fields that were only appended since are skipped.
std::vector<std::uint8_t> encode_frame_info(TrackRole role, const FrameInfo& info, TrackPosition position = {});
struct TaggedFrameInfo {
    TrackRole role = TrackRole::main;
    FrameInfo info;
    TrackPosition position;
};
std::optional<TaggedFrameInfo> decode_frame_info(std::span<const std::uint8_t> payload);

/// Bytes that FrameInfo::moving takes in a main picture's frame data, which hold no more than max_motion_bytes.
/// Throws InputError for regions that are not sound.
std::size_t motion_bytes(const FrameInfo& info);
inline constexpr std::size_t max_motion_bytes = 32768;

enum class Codec { h264, h265 };

/// What samples of colour mean: display-referred sRGB in 8 bits (yuv.h), or PQ in 10 (yuv.h), which keeps what is
/// brighter than white.
enum class Transfer { srgb, pq };

/// From one key frame to the next.
inline constexpr int max_group_pictures = 10000;

/// Encoders refuse smaller tracks.
inline constexpr int min_track_side = 64;

struct TrackSettings {
    TrackRole role = TrackRole::main;
    int width = 0;                            ///< even
    int height = 0;                           ///< even
    std::optional<DepthCodeId> depth_code{};  ///< of depth tracks: always; of others: never
    std::optional<double> crf{};              ///< nothing: the stream's; `lossless` has none
    /// Of main's and window's depth alone: coded at half the columns and rows (depth_code.h), which are then multiples
    /// of 4.
    bool halved = false;
    int coded_width() const { return halved ? width / 2 : width; }
    int coded_height() const { return halved ? height / 2 : height; }
    /// Which encoder: the stream's, or H.265 for what H.264 cannot code here (w12, hue, lossless).
    Codec codec(Codec stream_codec) const;
    /// The quality it is coded at: its own, else the stream's; nothing if nothing is lost.
    std::optional<double> coded_crf(double stream_crf) const;
};

struct StreamSettings {
    Codec codec = Codec::h264;
    Transfer transfer = Transfer::srgb;  ///< of all colour tracks
    double crf = 16;
    std::string preset = "medium";
    int gop = 30;  ///< pictures from one key frame to the next
    double frames_per_second = 30;
    std::vector<TrackSettings> tracks;
    std::string scene;  ///< container title
    /// What of a sphere main's pictures cover, for ordinary 360 players, where the container can say it (mp4, mkv);
    /// nothing: they are no spheres.
    std::optional<LongitudeLatitudeRange> sphere{};
    /// Said of the main track for ordinary players, where the container can (mp4, mkv).
    StereoPacking stereo = StereoPacking::none;
    /// Between both eyes, where they are packed and the container can say it (mp4); 0: not said.
    double baseline_m = 0;
    /// Pictures carry their frame data. Off for ordinary video, that nobody can pose.
    bool tagged = true;
    /// Pictures each track will hold. 0: not known, then each track runs one picture behind, because its last one
    /// says that it is the last.
    std::uint32_t pictures = 0;
    int threads = 4;  ///< the coded bytes depend on it, so it does not follow the machine
    /// Pictures that are made while others are watched: each one's bytes come as soon as it is written (nothing is
    /// reordered, nothing looked ahead for), key frames stand where begin_group() asks for them and no `pictures` are
    /// known. When it is finished each track's last picture comes once more, one frame later, to say that it is the
    /// last.
    bool live = false;
};
/// Throws InputError naming the first of crf, gop, threads and preset that cannot be used, with `before_names` before
/// its name: a program's options have dashes. Looks at nothing else; StreamWriter checks all settings by itself.
void check_coding(const StreamSettings& settings, const std::string& before_names = "");

/// Takes bytes as they are written; called by whoever calls StreamWriter.
struct StreamTap {
    std::function<void(std::span<const std::uint8_t>)> take;
    bool alone = true;  ///< no file is written
};

/// Encodes display-referred sRGB pictures (8-bit RGB), or PQ ones, and depth to `target`: a path ending in .mp4, .mkv,
/// .ts, .nut, .h264 or .h265 (the last two hold one track), or a URL (MPEG-TS, unless its path ends in one of those).
/// The same pictures and settings give the same bytes. A file is written as NAME.part and renamed by finish(); if that
/// is never reached, what was coded so far stays in NAME.part, playable. libav's own log is silenced. Throws InputError
/// for settings or targets that cannot be used, WorkError once coding has begun.
class StreamWriter {
public:
    /// The bytes go to `tap` too, or alone. `target` says the container and stands in errors all the same.
    StreamWriter(const std::string& target, const StreamSettings& settings, std::optional<StreamTap> tap = {});
    ~StreamWriter();
    StreamWriter(const StreamWriter&) = delete;
    StreamWriter& operator=(const StreamWriter&) = delete;

    /// Pictures of one track in display order, indices ascending; tracks interleave as they come. `tile`: which track
    /// of that role, where there are several.
    void write(TrackRole role, ImageView<const std::uint8_t> rgb, const FrameInfo& info, std::size_t tile = 0);
    /// The same where the transfer is pq: R'G'B' as yuv.h describes, 3 channels from 0 to 1.
    void write_pq(TrackRole role, ImageView<const float> rgb, const FrameInfo& info, std::size_t tile = 0);
    /// The same for depth tracks: metres along each pixel-centre ray, 1 channel. `info.depth_code` has the track's code
    /// and the range to use, the same one throughout a group of pictures; its clamped_pixels is counted here and its
    /// `halved` is the track's.
    void write_depth(TrackRole role, ImageView<const float> depth_m, const FrameInfo& info, std::size_t tile = 0);
    /// Of a live stream: whoever has the header can join at the next picture of each track.
    void begin_group();
    /// Of a live H.264 stream: the quality of a track from its next picture on, which says so in its frame data. Throws
    /// InputError for a CRF that there is not, WorkError where the encoder cannot change it.
    void set_crf(TrackRole role, double crf);
    /// Hands over what was written of a live stream, in Matroska as a cluster of its own.
    void flush();
    /// Flushes the encoders and ends the file; throws WorkError if the disk was full, and so on.
    void finish();
    /// Coded bytes so far, per track in the order of StreamSettings::tracks.
    std::vector<std::int64_t> bytes() const;
    /// Whether the main track carries the tag of a sphere.
    bool tags_sphere() const;
    /// Where an unfinished file stays; empty for URLs and devices.
    const std::string& unfinished_file() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// One decoded picture. Of a colour track it is 8-bit display-referred sRGB, as `rgb` or `yuv`, or `pq`; of a depth
/// track `depth_m`.
struct DecodedPicture {
    std::size_t track = 0;  ///< position in StreamReader::tracks(), which tells tiles apart
    TrackRole role = TrackRole::main;
    /// Absent in foreign videos. Of a tile only camera, index, time and coding are the picture's own: all else is as of
    /// its group's first picture, and main's of the same index has what holds.
    std::optional<FrameInfo> info;
    int width = 0;
    int height = 0;
    ByteImage rgb;   ///< RGB interleaved
    YuvPicture yuv;  ///< where StreamReadOptions::yuv asked for it
    PqPicture pq;    ///< where StreamReadOptions::pq asked for it
    /// Radial, +inf for a miss, NaN where the track holds no surface. Where info->depth_code is `halved`, each coded
    /// sample stands in its four pixels.
    FloatImage depth_m;
    /// When it is shown, after main's first picture; nothing where the container does not say.
    std::optional<double> time_s;
    std::string_view decoder;  ///< "software", or libavutil's name of the hardware: "vaapi", "cuda"
    double decode_ms = 0;      ///< time spent waiting for the decoder since this track's last picture
    double convert_ms = 0;     ///< YUV to RGB, or samples to depth
    std::int64_t bytes = 0;    ///< coded
};

struct StreamTrackSummary {
    TrackRole role = TrackRole::main;
    std::string name;  ///< as the container has it; empty where it has none
    std::string codec;
    int width = 0;
    int height = 0;
    double frames_per_second = 0;
    double most_frames_per_second = 0;  ///< where it varies, as far as libav found out; else the same
    std::string pixel_format;
    std::string colour;  ///< "range/primaries/transfer/matrix" in libav's names
    /// Tagged as equirectangular video, of which part of the sphere; nothing: not tagged so.
    std::optional<LongitudeLatitudeRange> sphere{};
    StereoPacking stereo = StereoPacking::none;  ///< as tagged
    bool right_first = false;                    ///< of packed eyes the right one's comes first
    std::optional<double> baseline_m{};          ///< between both eyes, as tagged
    bool has_vexu = false;                       ///< Apple's box says so, alone or beside others (mp4, mov)
    std::int64_t pictures = 0;                   ///< delivered so far
    std::int64_t bytes = 0;                      ///< coded bytes read so far
};

/// Whether a source or target is an address (PROTOCOL://..., pipe:...) rather than the name of a file.
bool is_url(const std::string& name);

/// Whether a source is a pipe: what was read of it cannot be read again. Asks the file system each time.
bool is_pipe(const std::string& name);

struct StreamReadOptions {
    bool rgb = true;  ///< false: decode, but leave DecodedPicture::rgb empty
    /// Give the decoder's own planes in place of rgb wherever they are as equistream/yuv.h describes, without
    /// conversion or copy.
    bool yuv = false;
    /// Give planes as equistream/yuv.h describes them in place of rgb, of PQ by BT.2020 with even sides: the decoder's
    /// own where they are so. Other HDR, and without this PQ too, comes as if it were sRGB: dull.
    bool pq = false;
    bool depth = true;      ///< false: depth tracks are not decoded beyond their first picture, nor given
    bool images = true;     ///< the same for the track of mirrors and glass
    TrackRoles left_out{};  ///< the same for these; never main
    /// Decode colour by hardware where there is some that can, without a word by software else. The standards of the
    /// codecs leave no choice: both give the same pictures.
    bool hardware = false;
    /// Where colour is decoded to, for as long as it has room; null: anywhere. Pictures are the same. What it gives is
    /// held by `yuv` and `pq`, and by the reader for pictures to come.
    std::shared_ptr<PictureMemory> memory{};

    bool wants(TrackRole role) const {
        if (role != TrackRole::main && left_out[std::size_t(role)])
            return false;
        return is_reflections(role) ? images : depth || !is_depth(role);
    }
    /// Asked often while the source keeps us waiting, in the thread that waits; true: give up, as if it ended there.
    std::function<bool()> interrupted{};
    /// Where the source's bytes come from, if it is not opened by its name: fills as much of the span as there is,
    /// waiting for at least one byte, and says how much; 0: they have ended.
    std::function<std::size_t(std::span<std::uint8_t>)> read{};
};

/// Decodes a file or URL, any ordinary video included. Sources are treated as hostile: sizes are held to image.h's
/// limits before anything is allocated, playlists are refused. A stream that was cut plays up to the cut; pictures
/// that arrived damaged are left out. One that is sent over and over ends where it begins again. Throws InputError for
/// what is no video, or of a version to come.
class StreamReader {
public:
    explicit StreamReader(const std::string& source, const StreamReadOptions& options = {});
    ~StreamReader();
    StreamReader(const StreamReader&) = delete;
    StreamReader& operator=(const StreamReader&) = delete;

    const std::vector<StreamTrackSummary>& tracks() const;
    const std::string& container() const;  ///< libav's long name
    /// Whether it comes from a server at that server's pace: an address in which nobody can seek, no pipe. Any thread.
    bool is_live() const;
    /// From the first picture to the end of the last, as the container says. Nothing where it does not, where nobody
    /// can go back in the source, of a fragmented mp4, and of a Matroska file that was cut.
    std::optional<double> seconds() const;
    /// The next picture of any track, in presentation order within each and side by side as far as they are
    /// interleaved; nothing at the end.
    std::optional<DecodedPicture> next();
    /// From here on next() gives pictures of each track from its last key frame on that is shown no later than so long
    /// after main's first picture, which must have been given; nothing before that key frame is decoded. Found by the
    /// container's index where it has one that leads there, else by reading packets from the beginning. False where
    /// neither can be (live sources, pipes, containers that keep no times): the reader is of no further use then.
    bool seek(double seconds);
    /// From here on as if StreamReadOptions::left_out had them too.
    void leave_out(TrackRoles roles);
    /// Of a track: the latest time of a picture whose coded bytes have come, after main's first picture. Nothing before
    /// main's first picture was given, and where the container keeps no times.
    std::optional<double> newest_s(std::size_t track) const;
    /// How far into a file it was read, in bytes; 0 for what has no such place.
    std::int64_t position() const;
    /// After the end: empty, or one line on how the stream ended early ("cut after frame 5 ...").
    const std::string& truncation() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Throws InputError naming `target`, what --out names, where a file is there that is no stream of ours: its first
/// track is not called "main", and its first pictures, a few of which are decoded, have no frame data. Empty files are
/// replaced.
void require_replaceable_stream(const std::string& target);

// Both eyes in one picture, as ordinary players and displays take them: one definition for what is encoded, played and
// viewed. Pictures are 8-bit RGB; a pure function.

/// The left eye's picture above, or to the left of, the right one's, of one size. `packing` is not none.
ByteImage packed_eyes(StereoPacking packing, ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right);
/// The same of distances.
FloatImage packed_eyes(StereoPacking packing, ImageView<const float> left_m, ImageView<const float> right_m);

}  // namespace equistream
