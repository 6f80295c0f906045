#pragma once
/// A whole comparison: every pair of pictures measured, pooled per eye.
#include "compared_pictures.h"
#include "picture_metrics.h"
#include "unbiased_error.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace equistream {

struct ComparisonOptions {
    bool psnr = true;
    bool ssim = true;
    bool sphere_psnr = false;        ///< pictures must be equirect; an EXR's range is used, a PNG is a full sphere
    bool whole = false;              ///< the whole error; needs a second truth
    bool flicker = false;            ///< of whole and noise-free error, whichever is measured
    std::optional<double> exposure;  ///< instead of each EXR frame's own
    std::string view = default_view;
    /// Empty: no difference pictures. Else a new folder, or one of earlier ones, as its differences.json says.
    std::filesystem::path difference_folder;
    /// Of pictures in memory: as many pairs are worked on at once as take no more, and one at least.
    std::int64_t bytes_at_once = std::int64_t{4} << 30;
};

/// How much |picture - truth| is amplified in difference pictures.
inline constexpr int difference_gain = 8;
inline constexpr double worst_fraction = 0.01;

struct FrameScore {
    std::optional<std::int64_t> frame;
    ErrorSum error;
    ErrorSum gap_error;     ///< no samples without masks
    ErrorSum sphere_error;  ///< no samples unless asked for
    Similarity similarity;
};

struct ScaleErrors {
    UnbiasedError linear;   ///< on radiance times exposure, clipped to [0, 1]
    UnbiasedError display;  ///< on display values before they are rounded to 8 bits
};

/// One kind of error without the truth's noise (unbiased_error.h); nothing where nothing was measured.
struct UnbiasedErrors {
    std::optional<ScaleErrors> all;
    std::optional<ScaleErrors> worst;    ///< of the worst 1 % of each frame's pixels
    std::optional<ScaleErrors> gaps;     ///< in the masks' pixels
    std::optional<ScaleErrors> flicker;  ///< of changes from frame to frame (flicker.h)
};

struct EyeScore {
    std::string eye;
    int width = 0;
    int height = 0;
    std::vector<FrameScore> frames;
    FrameScore pooled;      ///< sums over frames: errors pool, so its PSNR is that of the mean square error
    ErrorSum worst_pixels;  ///< the worst 1 % of all frames' pixels together
    UnbiasedErrors whole;
    UnbiasedErrors noise_free;
    bool flicker_by_motion = false;  ///< else of the same pixel of both frames

    /// The mean of the frames' own PSNR, of those that differ; +inf if all are identical.
    double mean_frame_psnr_db() const;
};

/// Measures one eye; frames run in parallel. `done` is told after each frame, from any thread.
/// Throws InputError for pictures that cannot be read or whose sizes differ, and where pictures share a file, a seed or
/// noise that must not (unbiased_error.h). So does a difference folder whose pictures would be replaced by others.
EyeScore compare_eye(const EyePairs& pairs, const ComparisonOptions& options, const std::function<void()>& done = {});

}  // namespace equistream
