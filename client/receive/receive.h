#pragma once
/// Pictures as they arrive, and what engines take of them.
#include <equistream/colour.h>
#include <equistream/frame.h>
#include <equistream/stream.h>
#include <equistream/yuv.h>

#include <client/transport/pose_sender.h>
#include <client/warp/view.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace equistream {

// Pictures as they arrive: from a stream (file or URL), or from a folder of rendered frames as if they had been coded
// without loss. All pictures of one frame come together.

/// One picture and where it was seen from.
struct ReceivedPicture {
    FrameInfo info;
    ByteImage rgb;       ///< display-referred sRGB, 3 channels; empty where `yuv` or `pq` is given
    YuvPicture yuv;      ///< the decoder's own planes, where FeedOptions::yuv asked for them and they are of that kind
    PqPicture pq;        ///< the same of an HDR stream, where FeedOptions::pq asked for them
    FloatImage depth_m;  ///< where it was asked for and is there: the renderer's AOV, or the depth track's; else empty
    /// Mirrors and glass (SourceView): of the main picture, where they were asked for and are there.
    FloatImage specular, virtual_depth_m;
    std::string_view decoder;  ///< of colour: DecodedPicture's; empty where nothing was coded
    double decode_ms = 0;      ///< of colour and depth
    double convert_ms = 0;     ///< the same

    int width() const { return !pq.empty() ? pq.planes.y.width : yuv.empty() ? rgb.width() : yuv.planes.y.width; }
    int height() const { return !pq.empty() ? pq.planes.y.height : yuv.empty() ? rgb.height() : yuv.planes.y.height; }
};

/// What is missing of a frame (lost, or not sent) is left out; a frame without its main picture is not given at all.
struct ReceivedFrame {
    ReceivedPicture main;                 ///< what eyes are made of: the window, where one came, else the sphere
    std::optional<ReceivedPicture> base;  ///< the sphere around `main`, where that is a window; of the same pose
    std::optional<ReceivedPicture> small;
    std::optional<ReceivedPicture> hidden;   ///< the second layer: main's camera, pose and size
    std::optional<ReceivedPicture> patches;  ///< the atlas that info.patches describes
    /// False for foreign video, which carries no pose: a sphere around nobody's head. By omnidirectional stereo rays
    /// begin nowhere that eyes would be, so that it counts as such too; its axes are told.
    bool posed = true;
    std::optional<std::uint32_t> ordinal;  ///< of the main track's picture (DecodedPicture); nullopt: not of a stream
    /// The right eye's, of video with both in each picture (StereoPacking); the left one is `main`.
    std::optional<ReceivedPicture> right;
    /// Views of the same frame that were rendered beside it, for their depth only (folders; rgb is empty).
    std::vector<ReceivedPicture> depth_views;
};

/// Bytes as they came, of one track or one folder: of the frames that were given, and of no others.
struct FeedTrack {
    std::string name;
    std::int64_t pictures = 0;
    std::int64_t bytes = 0;
};

/// Throws WorkError where a picture or a plane of it has another size than its tag says, by which it is looked up. So
/// too where a picture other than `patches` says that it is an atlas.
void require_tagged_sizes(const ReceivedFrame& frame);

/// What a source says of itself, for people.
struct FeedSummary {
    std::string kind;                    ///< "a folder of frames", or the container in libav's words
    std::string codec;                   ///< of the main pictures, in libav's words; empty: nothing was coded
    std::optional<double> seconds;       ///< from the first frame to the end of the last; nothing: not known
    std::optional<std::int64_t> frames;  ///< the same; nothing: not counted
};

class FrameFeed {
public:
    virtual ~FrameFeed() = default;
    /// The next frame in order; nothing at the end.
    virtual std::optional<ReceivedFrame> next() = 0;
    /// After the end: empty, or one line on why there was no more ("walk.mp4: main was cut after frame 5 ...").
    virtual std::string truncation() const = 0;
    /// What has been given so far.
    virtual std::vector<FeedTrack> tracks() const = 0;
    /// From 0 to 1; nothing where the end is not known.
    virtual std::optional<double> fraction_done() const = 0;
    /// Whether frames come at their server's pace, as StreamReader::is_live; else they wait to be asked for.
    virtual bool is_live() const = 0;
    /// How each track says that its samples stand for light, by libav's names ("smpte2084": PQ), whether or not a
    /// picture of it has come. Of folders none.
    virtual std::vector<std::string> transfers() const = 0;
    virtual FeedSummary summary() const = 0;
    /// From here on next() gives the frames from this one on, also where it is before FeedOptions::first_frame; of a
    /// stream no more is decoded for that than the group of pictures it is in. False where that cannot be done
    /// (StreamReader::seek, before the first frame, with frames_ahead): the feed is of no further use then.
    virtual bool seek(std::int64_t frame) = 0;
};

struct FeedOptions {
    bool depth = false;     ///< fill ReceivedPicture::depth_m: from depth tracks, or the depth AOV of folders
    bool hardware = false;  ///< as in StreamReadOptions
    std::shared_ptr<PictureMemory> memory{};  ///< the same
    bool yuv = false;  ///< the decoder's own planes in place of rgb; nothing changes for folders and foreign formats
    bool pq = false;   ///< the same of HDR streams, which are else brought to `hdr_display`
    /// Null: HdrDisplay's defaults. Where one is given, and HDR is not what comes, next() throws InputError.
    std::shared_ptr<const HdrDisplay> hdr_display{};
    /// Fill ReceivedPicture::specular and virtual_depth_m of the main picture: from the track of mirrors and glass,
    /// or those AOVs of folders.
    bool specular = false;
    /// What nobody needs (never main) is neither decoded nor given, and of folders not read. Asked before each frame,
    /// with frames_ahead by that thread; what was left out once stays so.
    std::function<TrackRoles()> left_out{};
    std::int64_t first_frame = 0;
    std::int64_t last_frame = INT64_MAX;
    /// So many frames, and the one being read, are got ready by a thread of the feed's own while the caller works on
    /// those before; 0: read when asked for. Frames, their order and what next() throws are the same.
    std::size_t frames_ahead = 0;
    std::function<bool()> interrupted{};  ///< as in StreamReadOptions; with frames_ahead called by that thread
    /// A stream whose first frame is not whole by then is given up with a WorkError, whatever comes of it meanwhile.
    double first_frame_limit_s = std::numeric_limits<double>::infinity();
    /// Of a stream that comes from a server: what is sent with it goes there. Borrowed.
    PoseSender* poses = nullptr;
};

/// A folder of rendered frames, else a stream. Throws InputError naming what could not be opened.
std::unique_ptr<FrameFeed> open_feed(const std::string& source, const FeedOptions& options = {});

// A received picture as engines and fill passes take it. What comes out borrows the picture's pixels. Pure functions.

/// Of the head box around the picture's centre (bound.h), metres.
double head_box_radius(const FrameInfo& info);

/// `depth_m` as in SourceView; empty: not known.
SourceView source_view(const ReceivedPicture& picture, const FloatImage& depth_m);

}  // namespace equistream
