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
    patches = 5,        ///< atlas of patches: surfaces that eyes in the head box uncover (patches.h)
    patches_depth = 6,  ///< the atlas's radial depth, of each patch from its own auxiliary sphere's centre
    reflections = 7,    ///< virtual depth of main's mirrors and glass; no surface (NaN) at other pixels
    /// A window of a denser sphere, around the gaze (window.h); main is the base. Several tracks of this role are
    /// tiles: windows at different places that together cover the denser sphere.
    window = 8,
    window_depth = 9,         ///< window's radial depth
    window_reflections = 10,  ///< virtual depth of window's mirrors and glass
};
inline constexpr int track_role_count = 11;
/// Most tracks of a stream, each tile counted: Matroska's limit.
inline constexpr std::size_t max_stream_tracks = 127;
using TrackRoles = std::bitset<track_role_count>;  ///< indexed by TrackRole's value

const char* track_name(TrackRole role);  ///< "main", "small", "depth", "hidden", "hidden-depth", ...; static storage

/// Whether pictures of this role are distances, coded by a DepthCode (depth_code.h).
bool is_depth(TrackRole role);
/// The role of a colour track's depth; nullopt for small, which has none.
std::optional<TrackRole> depth_role_of(TrackRole colour);
/// The role of main's or window's reflections; nullopt for other roles.
std::optional<TrackRole> reflections_role_of(TrackRole colour);
/// Whether pictures of this role may be coded at half the columns and rows: depth and window_depth.
bool may_be_halved(TrackRole role);
/// Whether the role is reflections or window_reflections.
bool is_reflections(TrackRole role);
/// Whether a stream may have several tracks of this role; they are tiles.
bool may_be_tiled(TrackRole role);

/// Position of a picture in its track. It reveals cuts and gaps in any container.
struct TrackPosition {
    std::uint32_t ordinal = 0;  ///< 0 for the track's first picture
    std::uint32_t count = 0;    ///< pictures in the track; 0: not known yet. The track's last picture has the number
};

/// FrameInfo <-> payload of an SEI user_data_unregistered message, UUID included. encode throws InputError for a name
/// above 255 bytes. decode returns nullopt for another UUID, and throws WorkError for a damaged payload. For an unknown
/// version, whose layout is newer, it throws InputError. It skips fields that newer programs have appended.
std::vector<std::uint8_t> encode_frame_info(TrackRole role, const FrameInfo& info, TrackPosition position = {});
struct TaggedFrameInfo {
    TrackRole role = TrackRole::main;
    FrameInfo info;
    TrackPosition position;
};
std::optional<TaggedFrameInfo> decode_frame_info(std::span<const std::uint8_t> payload);

/// Size in bytes of FrameInfo::moving in a main picture's frame data, which has room for max_motion_bytes. Throws
/// InputError for invalid regions (moving_regions_problem).
std::size_t motion_bytes(const FrameInfo& info);
inline constexpr std::size_t max_motion_bytes = 32768;

enum class Codec { h264, h265 };

/// Encoding of colour samples (yuv.h): display-referred sRGB in 8 bits, or PQ in 10 bits, which keeps light brighter
/// than white.
enum class Transfer { srgb, pq };

/// Most pictures of a group, from one key frame to the next.
inline constexpr int max_group_pictures = 10000;

/// Smallest coded width and height of a track, in pixels.
inline constexpr int min_track_side = 64;

struct TrackSettings {
    TrackRole role = TrackRole::main;
    int width = 0;                            ///< pixels, even, min_track_side to max_image_side
    int height = 0;                           ///< the same
    std::optional<DepthCodeId> depth_code{};  ///< required for depth tracks; not allowed for others
    std::optional<double> crf{};              ///< 0 to worst_crf; nullopt: the stream's. Unused by `lossless`
    /// Coded at half the columns and rows (depth_code.h). For roles of may_be_halved(); width and height are then
    /// multiples of 4, at least 128.
    bool halved = false;
    int coded_width() const { return halved ? width / 2 : width; }
    int coded_height() const { return halved ? height / 2 : height; }
    /// The track's codec: the stream's, but H.265 for depth codes that H.264 cannot code here (w12, hue, lossless).
    Codec codec(Codec stream_codec) const;
    /// The constant rate factor in use: the track's own, else the stream's; nullopt for `lossless`.
    std::optional<double> coded_crf(double stream_crf) const;
};

struct StreamSettings {
    Codec codec = Codec::h264;
    Transfer transfer = Transfer::srgb;  ///< of all colour tracks
    double crf = 16;                     ///< constant rate factor of x264 and x265, 0 (best) to worst_crf
    std::string preset = "medium";       ///< of x264 and x265, "ultrafast" to "placebo"
    int gop = 30;                        ///< pictures from one key frame to the next, 1 to max_group_pictures
    double frames_per_second = 30;       ///< 0.01 to 1000
    std::vector<TrackSettings> tracks;   ///< 1 to max_stream_tracks; only tiles share a role
    std::string scene;                   ///< title of the container
    /// The range of longitudes and latitudes in main's pictures, a tag for ordinary 360 players (mp4, mkv); nullopt:
    /// the pictures are no spheres.
    std::optional<LongitudeLatitudeRange> sphere{};
    /// Packing of main's pictures, a tag for ordinary players (mp4, mkv).
    StereoPacking stereo = StereoPacking::none;
    /// Distance between packed eyes, a tag for ordinary players (mp4); 0: no tag.
    double baseline_m = 0;
    /// Pictures carry their frame data. False: ordinary video, without poses.
    bool tagged = true;
    /// Number of pictures of each track. 0: not known; then the writer holds each track's newest picture back, because
    /// the last one is marked.
    std::uint32_t pictures = 0;
    int threads = 4;  ///< 1 to 64 for each track's encoder; a fixed default, because the coded bytes depend on it
    /// Live encoding, with the lowest latency: each picture's bytes leave as soon as it is written, without reordering
    /// or look-ahead. Key frames stand where begin_group() asks for them, and `pictures` is 0. finish() repeats each
    /// track's last picture, one frame later, to mark it as the last.
    bool live = false;
};
/// Checks crf, gop, threads and preset alone; StreamWriter checks all settings. Throws InputError naming the first
/// invalid one, with the prefix `before_names`, such as the dashes of a program's options.
void check_coding(const StreamSettings& settings, const std::string& before_names = "");

/// Receives the coded bytes.
struct StreamTap {
    /// Called within StreamWriter's calls, in their thread. The bytes are valid during the call.
    std::function<void(std::span<const std::uint8_t>)> take;
    bool alone = true;  ///< true: no file is written
};

/// Encodes display-referred sRGB pictures (8-bit RGB), or PQ ones, and depth to `target`: a path ending in .mp4, .mkv,
/// .ts, .nut, .h264 or .h265 (the last two hold one track), or a URL (MPEG-TS, unless its path ends in one of those).
/// The same pictures and settings give the same bytes. A file is written as NAME.part and renamed by finish(). Without
/// finish(), NAME.part stays, playable up to the last coded picture. libav's own log is silenced. Throws InputError for
/// invalid settings or targets, WorkError once coding has begun.
class StreamWriter {
public:
    /// With `tap` the bytes go to the tap, and to the target unless tap->alone. `target` decides the container, and
    /// errors name it, in either case.
    StreamWriter(const std::string& target, const StreamSettings& settings, std::optional<StreamTap> tap = {});
    ~StreamWriter();
    StreamWriter(const StreamWriter&) = delete;
    StreamWriter& operator=(const StreamWriter&) = delete;

    /// Writes 8-bit RGB, 3 channels of the track's size. Each track gets its pictures in display order, with ascending
    /// indices; tracks may come in any order. `tile`: number of the track among those with this role, from 0.
    void write(TrackRole role, ImageView<const std::uint8_t> rgb, const FrameInfo& info, std::size_t tile = 0);
    /// The same for Transfer::pq: R'G'B' as yuv.h describes, 3 channels from 0 to 1.
    void write_pq(TrackRole role, ImageView<const float> rgb, const FrameInfo& info, std::size_t tile = 0);
    /// The same for depth tracks: metres along each pixel-centre ray, 1 channel. `info.depth_code` has the track's code
    /// and the range to use, one range for a whole group of pictures. The writer sets its clamped_pixels and `halved`.
    void write_depth(TrackRole role, ImageView<const float> depth_m, const FrameInfo& info, std::size_t tile = 0);
    /// Live stream: the next picture of each track is a key frame, where readers that have the header can join.
    void begin_group();
    /// H.264 tracks of a live stream: changes the constant rate factor from the track's next picture on. Frame data
    /// carry the new value. Throws InputError unless `crf` is 0 to worst_crf, WorkError if the track is no lossy H.264.
    void set_crf(TrackRole role, double crf);
    /// H.264 tracks of a live stream: the track's pictures have another size from the next one on, which begins a group
    /// (begin_group). Each group of a live stream has its parameter sets in its first packet. Throws InputError for a
    /// size that no track may have, WorkError if the track is no H.264 or the stream is not live.
    void set_size(TrackRole role, int width, int height);
    /// Live stream: passes on all bytes of the pictures written so far. In Matroska it ends the cluster.
    void flush();
    /// Flushes the encoders, ends the stream and renames the file. Throws WorkError if bytes could not be written, or a
    /// track has another number of pictures than StreamSettings::pictures. Nothing may be written afterwards.
    void finish();
    /// Coded bytes so far, per track in the order of StreamSettings::tracks.
    std::vector<std::int64_t> bytes() const;
    /// Whether the container carries the tag of StreamSettings::sphere.
    bool tags_sphere() const;
    /// Path of NAME.part; empty for URLs, devices and a tap alone.
    const std::string& unfinished_file() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// One decoded picture. A colour track fills one of `rgb`, `yuv` and `pq`, a depth track `depth_m`.
struct DecodedPicture {
    std::size_t track = 0;  ///< index in StreamReader::tracks(); tiles differ in it
    TrackRole role = TrackRole::main;
    /// nullopt in foreign videos. For a tile only camera, index, time and coding are the picture's own. All other
    /// fields are copies from its group's first picture; main's picture with the same index has the valid ones.
    std::optional<FrameInfo> info;
    /// Number of the picture in its track, from 0, as the sender counts: a gap is a picture that did not come. A live
    /// scene's frame numbers have gaps of their own. nullopt in foreign videos.
    std::optional<std::uint32_t> ordinal;
    int width = 0;
    int height = 0;
    ByteImage rgb;   ///< 8-bit display-referred sRGB, 3 channels
    YuvPicture yuv;  ///< the same in the decoder's planes, with StreamReadOptions::yuv
    PqPicture pq;    ///< HDR, with StreamReadOptions::pq
    /// Radial depth; +inf for a miss, NaN for a pixel without a surface. If info->depth_code is `halved`, each coded
    /// sample fills its four pixels.
    FloatImage depth_m;
    /// Display time, from main's first picture; nullopt if the container has no times.
    std::optional<double> time_s;
    std::string_view decoder;  ///< "software", or libavutil's name of the hardware: "vaapi", "cuda"
    double decode_ms = 0;      ///< time spent waiting for the decoder since this track's last picture
    double convert_ms = 0;     ///< time for YUV to RGB, or samples to depth
    std::int64_t bytes = 0;    ///< size of the coded picture
};

/// Properties of a track, from the container and the pictures decoded so far.
struct StreamTrackSummary {
    TrackRole role = TrackRole::main;
    std::string name;   ///< in the container; empty if it has none
    std::string codec;  ///< libav's name
    int width = 0;
    int height = 0;
    double frames_per_second = 0;
    double max_frames_per_second = 0;  ///< largest rate, by libav's estimate, of a track whose rate varies
    std::string pixel_format;          ///< libav's name
    std::string colour;                ///< "range/primaries/transfer/matrix" in libav's names
    /// Range of a track tagged as equirectangular video; nullopt: no tag.
    std::optional<LongitudeLatitudeRange> sphere{};
    StereoPacking stereo = StereoPacking::none;  ///< tagged packing
    bool right_first = false;                    ///< tag: the right eye comes first in packed pictures
    std::optional<double> baseline_m{};          ///< tagged distance between the eyes
    bool has_vexu = false;      ///< Apple's vexu box has these tags, perhaps beside other boxes (mp4, mov)
    std::int64_t pictures = 0;  ///< delivered so far
    std::int64_t bytes = 0;     ///< coded bytes read so far
};

/// Whether a source or target is an address (PROTOCOL://..., pipe:...) rather than the name of a file.
bool is_url(const std::string& name);

/// Whether a source is a pipe, whose bytes can be read only once. Asks the file system each time.
bool is_pipe(const std::string& name);

struct StreamReadOptions {
    bool rgb = true;  ///< false: decode, but leave DecodedPicture::rgb empty
    /// Give the decoder's own planes instead of rgb, without conversion or copy, if they have yuv.h's 8-bit layout.
    bool yuv = false;
    /// Give the 10-bit planes of yuv.h instead of rgb, for PQ with BT.2020 and even width and height; the decoder's own
    /// planes if they have that layout. Other HDR, and PQ without this option, is decoded as if it were sRGB and looks
    /// dull.
    bool pq = false;
    bool depth = true;      ///< false: skip depth tracks after their first picture
    bool images = true;     ///< the same for reflections
    TrackRoles left_out{};  ///< skip these roles in the same way; main is never skipped
    /// Decode colour by hardware if possible, else silently by software. Both give the same pictures, because the
    /// codecs' standards define decoding exactly.
    bool hardware = false;
    /// Memory to decode colour into while it has room; null: ordinary memory. Pictures are the same. `yuv` and `pq`
    /// hold its blocks, and so does the reader for later pictures.
    std::shared_ptr<PictureMemory> memory{};

    bool wants(TrackRole role) const {
        if (role != TrackRole::main && left_out[std::size_t(role)])
            return false;
        return is_reflections(role) ? images : depth || !is_depth(role);
    }
    /// Called often, in the reading thread, while the reader waits for the source. True ends the stream there.
    std::function<bool()> interrupted{};
    /// Reads the source's bytes; if empty, the source is opened by its name. Waits for at least one byte, fills the
    /// span with what is available, and returns the number of bytes; 0: the end.
    std::function<std::size_t(std::span<std::uint8_t>)> read{};
};

/// Decodes a file or URL, ordinary video too. Sources are treated as hostile: sizes are checked against image.h's
/// limits before anything is allocated, and playlists are refused. A cut stream plays up to the cut; damaged pictures
/// are skipped. A stream that is sent in a loop ends where it repeats. Throws InputError for a source that is no video,
/// or whose frame data have an unknown version; WorkError for a server that does not answer.
class StreamReader {
public:
    explicit StreamReader(const std::string& source, const StreamReadOptions& options = {});
    ~StreamReader();
    StreamReader(const StreamReader&) = delete;
    StreamReader& operator=(const StreamReader&) = delete;

    /// In the container's order; next() updates them.
    const std::vector<StreamTrackSummary>& tracks() const;
    const std::string& container() const;  ///< libav's long name
    /// Whether a server sends the stream at its own pace: an address that cannot seek and is no pipe. Any thread.
    bool is_live() const;
    /// Duration from the first picture to the end of the last, by the container. nullopt if it has none, for sources
    /// that cannot seek, for a fragmented mp4, and for a cut Matroska file.
    std::optional<double> seconds() const;
    /// The next picture of any track; nullopt at the end. Each track's pictures come in display order. Tracks alternate
    /// as the file interleaves them.
    std::optional<DecodedPicture> next();
    /// Jumps to a time in seconds after main's first picture, which next() must have given before. next() then gives
    /// each track's pictures from its last key frame at or before that time. Uses the container's index, or else reads
    /// packets from the beginning. False, with an unusable reader, for live sources, pipes and containers without
    /// times.
    bool seek(double seconds);
    /// Adds roles to StreamReadOptions::left_out, from the next picture on.
    void leave_out(TrackRoles roles);
    /// Latest display time, from main's first picture, of the pictures of a track whose coded bytes have been read.
    /// `track` is an index in tracks(). nullopt before main's first picture, and without times in the container.
    std::optional<double> newest_s(std::size_t track) const;
    /// Bytes read so far, as an offset in the file; 0 for a source without offsets.
    std::int64_t position() const;
    /// After the end: one line on how the stream ended early ("cut after frame 5 ..."); empty for a complete stream.
    const std::string& truncation() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Protects other files from being overwritten by --out. Throws InputError naming `target` if it is a file that is no
/// stream of equistream: its first track is not called "main", and its first four pictures have no frame data. Empty
/// files may be replaced.
void require_replaceable_stream(const std::string& target);

/// Packs both eyes for ordinary players and displays: the left eye's picture above the right one's, or to its left.
/// Both have one size and the same channels. `packing` is not none. A pure function.
ByteImage packed_eyes(StereoPacking packing, ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right);
/// The same for depth.
FloatImage packed_eyes(StereoPacking packing, ImageView<const float> left_m, ImageView<const float> right_m);

}  // namespace equistream
