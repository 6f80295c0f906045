#pragma once
/// What of a rendered frame moves by itself, for its frame data.
#include "depth_tracks.h"
#include "sources.h"

#include <equistream/colour.h>
#include <equistream/sequence.h>
#include <equistream/stream.h>
#include <equistream/window.h>

#include <plugin/motion/find_moving_regions.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace equistream {

/// Planes that motion is found in, of those that frames as this one have. Throws InputError naming the file and what it
/// lacks.
std::vector<std::string> motion_planes(const std::filesystem::path& file);

/// `frame` is the one of that index in the folder, read with motion_planes. Its neighbours are there or not: of those
/// that are, poses are read.
FoundMotion find_motion(const std::filesystem::path& folder, const Frame& frame, std::int64_t index);

/// Of a whole sequence.
struct MotionTotals {
    std::int64_t frames = 0;       ///< in which something moves
    std::int64_t max_regions = 0;  ///< in a frame
    std::int64_t left_out = 0;     ///< regions that found no room in their frame's data
    std::int64_t bytes = 0;        ///< in frame data, beyond those that say that nothing moves
    /// Over moving pixels, display pixels at the focal length of the bound, in extrapolation_horizon_s.
    double mean_motion_px = 0, mean_error_px = 0, worst_p95_error_px = 0;

    /// Moves what was found into `info`, the smallest regions left out where there is no room.
    void add(const FoundMotion& found, FrameInfo& info);

private:
    double pixels_ = 0;
};

// Rendered frames as pictures to be coded, and whether they belong together.

/// One frame of one track, ready to be coded.
struct Picture {
    TrackRole role = TrackRole::main;
    FrameInfo info;
    std::optional<FrameInfo> right_info;  ///< the other eye's, where both are in the picture
    /// False where the right eye is not where left one's head has it: then no client can pose the two.
    bool is_posed = true;
    ByteImage rgb;  ///< display-referred
    FloatImage pq;  ///< in its place, where that is the transfer
    int width() const { return pq.empty() ? rgb.width() : pq.width(); }
    int height() const { return pq.empty() ? rgb.height() : pq.height(); }
    void write(StreamWriter& writer, const FrameInfo& tagged) const;
    /// Of the tracks that go with its own, in their order.
    std::vector<std::pair<const DepthTrack*, FloatImage>> distances_m;
    std::size_t tile = 0;               ///< of a window that is one of several: its number
    std::shared_ptr<Picture> base;      ///< of main that is to be cut into tiles: the coarser sphere
    std::optional<FoundMotion> motion;  ///< of main, where it was asked for
    std::int64_t not_finite_samples = 0;
    double read_ms = 0;
    double display_ms = 0;
    double motion_ms = 0;
};

/// What colours are coded for.
class ColourCoding {
public:
    explicit ColourCoding(Transfer transfer) {
        if (transfer == Transfer::pq)
            pq_.emplace();
        else
            display_.emplace();
    }
    void operator()(ImageView<const float> linear, double exposure, Picture& picture) const {
        if (pq_)
            picture.pq = pq_->encode(linear, exposure);
        else
            picture.rgb = quantise_8bit(display_->to_display(linear, exposure).view());
    }

private:
    std::optional<DisplayTransform> display_;
    std::optional<PqEncoding> pq_;
};

/// Main's sphere cut into windows side by side, within a coarser sphere that is made of it.
struct TilePlan {
    TileGrid grid;
    int base_columns = 0;
};

/// What is read of frames beside their colour.
struct ReadPlan {
    DepthPlan depth;
    std::vector<std::string> motion_planes;  ///< of main; none: motion is not asked for
    std::optional<TilePlan> tiles;
};

/// The role of what goes with a picture: of its depth, or of its mirrors and glass.
TrackRole distances_role(const Picture& picture, const DepthTrack& track);
/// Whether these distances of it are coded at half the columns and rows.
bool is_halved(const DepthTrack& track, const FloatImage& distances_m);

/// Every track's, main's first, with what the plan wants beside it. Throws InputError naming the file.
std::vector<Picture> read_frame(const Sources& sources, const ReadPlan& plan, std::int64_t index,
                                const ColourCoding& coding);

/// The same with the base in main's place, and main's tiles behind all others. Pictures of read_frame with this plan.
std::vector<Picture> in_tiles(std::vector<Picture> pictures, const TilePlan& plan);

/// What can be seen before the first picture is coded, with the folder's name in front.
void check_sizes(const std::vector<Picture>& first, const Sources& sources);

/// That each track is of one render throughout, and all of the same one. Keeps the sources.
class SourceRenders {
public:
    explicit SourceRenders(const Sources& sources);
    /// One frame's pictures, in the order of the tracks. Throws InputError naming file and difference.
    void check(const std::vector<Picture>& pictures);

private:
    const Sources& sources_;
    std::vector<OneRender> renders_;
    std::optional<OneRender> right_eye_;
    std::optional<bool> is_posed_;  ///< of the first frame, and so of all
};

}  // namespace equistream
