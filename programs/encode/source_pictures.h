#pragma once
/// Rendered frames as pictures to be coded, and whether they belong together.
#include "depth_tracks.h"
#include "frame_motion.h"

#include <equistream/colour.h>
#include <equistream/sequence.h>
#include <equistream/stream.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace equistream {

/// What colours are coded for.
class ColourCoding {
public:
    explicit ColourCoding(Transfer transfer) {
        if (transfer == Transfer::pq)
            pq_.emplace();
        else
            display_.emplace();
    }
    struct Coded {
        ByteImage rgb;  ///< display-referred
        FloatImage pq;  ///< where the transfer is that; `rgb` is empty then
    };
    Coded operator()(ImageView<const float> linear, double exposure) const {
        Coded coded;
        if (pq_)
            coded.pq = pq_->encode(linear, exposure);
        else
            coded.rgb = quantise_8bit(display_->to_display(linear, exposure).view());
        return coded;
    }

private:
    std::optional<DisplayTransform> display_;
    std::optional<PqEncoding> pq_;
};

/// One frame of one track, ready to be coded.
struct Picture {
    TrackRole role = TrackRole::main;
    FrameInfo info;
    std::optional<FrameInfo> right_info;  ///< the other eye's, where both are in the picture
    ByteImage rgb;
    FloatImage pq;  ///< in its place, where that is the transfer
    int width() const { return pq.empty() ? rgb.width() : pq.width(); }
    int height() const { return pq.empty() ? rgb.height() : pq.height(); }
    void write(StreamWriter& writer, const FrameInfo& tagged) const;
    /// Of the tracks that go with its own, in their order.
    std::vector<std::pair<const DepthTrack*, FloatImage>> distances_m;
    std::optional<FoundMotion> motion;  ///< of main, where it was asked for
    std::int64_t not_finite_samples = 0;
    double read_ms = 0;
    double display_ms = 0;
    double motion_ms = 0;
};

/// What is read of frames beside their colour.
struct ReadPlan {
    DepthPlan depth;
    std::vector<std::string> motion_planes;  ///< of main; none: motion is not asked for
};

/// Every track's, main's first, with what the plan wants beside it. Throws InputError naming the file.
std::vector<Picture> read_frame(const Sources& sources, const ReadPlan& plan, std::int64_t index,
                                const ColourCoding& coding);

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
};

}  // namespace equistream
