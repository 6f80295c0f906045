#pragma once
/// A received picture as it is some time after it was taken: its moving regions (equistream/object_motion.h)
/// extrapolated by their motion, nearest first, before and behind what rests as depth says. A forward pass finds which
/// pixels they come to and how far away they are there, a backward one looks up each of these pixels in the region it
/// came from: outlines are the region's own, and its colours are resampled once. What they uncover shows no surface
/// (depth is NaN), so that engines make a gap of it and the fill chain fills it.
#include <client/receive/receive.h>

#include <cstdint>
#include <vector>

namespace equistream {

struct ExtrapolatedPicture {
    ReceivedPicture picture;  ///< rgb always; info is that of the picture it comes from; depth_m empty
    FloatImage depth_m;       ///< of the whole picture
    std::int64_t moved_pixels = 0, uncovered_pixels = 0;
};

/// Whether extrapolating changes anything at all.
bool can_extrapolate(const ReceivedPicture& picture, double seconds);

/// Keeps memory from picture to picture. One thread at a time.
class PictureExtrapolator {
public:
    /// `depth_m` has the picture's size. `extrapolated` keeps its memory from the time before.
    void extrapolate(const ReceivedPicture& picture, const FloatImage& depth_m, double seconds,
                     ExtrapolatedPicture& extrapolated);

private:
    struct Candidate {
        float distance_m;
        int region;
    };
    std::vector<int> region_;            ///< of each pixel before, -1: of none
    std::vector<Candidate> candidates_;  ///< of each pixel afterwards
    std::vector<std::size_t> reached_;   ///< that have a candidate
};

}  // namespace equistream
