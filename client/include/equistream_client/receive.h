#pragma once
/// Pictures as they arrive: from a stream (file or URL), or from a folder of rendered frames as if they had been coded
/// without loss. The main picture and the small second-eye picture of the same frame come together.
#include <equistream/frame.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace equistream {

/// One picture and where it was seen from.
struct ReceivedPicture {
    FrameInfo info;
    ByteImage rgb;       ///< display-referred sRGB, 3 channels
    FloatImage depth_m;  ///< the renderer's AOV where it was asked for; else empty
    double decode_ms = 0;
    double convert_ms = 0;
};

struct ReceivedFrame {
    ReceivedPicture main;
    std::optional<ReceivedPicture> small;
    bool posed = true;  ///< false for foreign video, which carries no pose: a full sphere around nobody's head
    /// Views of the same frame that were rendered beside it, for their depth only (folders; rgb is empty).
    std::vector<ReceivedPicture> depth_views;
};

/// Bytes as they came, of one track or one folder: of the frames that were given, and of no others.
struct FeedTrack {
    std::string name;
    std::int64_t pictures = 0;
    std::int64_t bytes = 0;
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
};

struct FeedOptions {
    bool depth = false;  ///< read the depth AOV too (folders)
    std::int64_t first_frame = 0;
    std::int64_t last_frame = INT64_MAX;
    std::function<bool()> interrupted{};  ///< as in StreamReadOptions
};

/// A folder of rendered frames, else a stream. Throws InputError naming what could not be opened.
std::unique_ptr<FrameFeed> open_feed(const std::string& source, const FeedOptions& options = {});

}  // namespace equistream
