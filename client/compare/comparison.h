#pragma once
/// A whole comparison: every pair of pictures measured, pooled per eye.
#include "compared_pictures.h"
#include "noise_free.h"
#include "picture_metrics.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace equistream {

struct ComparisonOptions {
    bool psnr = true;
    bool ssim = true;
    bool sphere_psnr = false;        ///< pictures must be equirect; an EXR's range is used, a PNG is a full sphere
    std::optional<double> exposure;  ///< instead of each EXR frame's own
    std::string view = default_view;
    std::filesystem::path difference_folder;  ///< empty: no difference pictures
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

struct NoiseFreeErrors {
    NoiseFreeError linear;   ///< on radiance times exposure, clipped to [0, 1]
    NoiseFreeError display;  ///< on display values before they are rounded to 8 bits
};

struct EyeScore {
    std::string eye;
    int width = 0;
    int height = 0;
    std::vector<FrameScore> frames;
    FrameScore pooled;      ///< sums over frames: errors pool, so its PSNR is that of the mean square error
    ErrorSum worst_pixels;  ///< the worst 1 % of all frames' pixels together
    std::optional<NoiseFreeErrors> noise_free;
    std::optional<NoiseFreeErrors> worst_noise_free;  ///< of the worst 1 % of each frame's pixels
    std::optional<NoiseFreeErrors> gaps_noise_free;   ///< in the masks' pixels

    /// The mean of the frames' own PSNR; +inf if any frame is identical.
    double mean_frame_psnr_db() const;
};

/// Measures one eye; frames run in parallel. `done` is told after each frame, from any thread.
/// Throws InputError for pictures that cannot be read or whose sizes differ, and for a second run that shares pictures,
/// seed or noise with the first. So does a difference folder that would take the compared pictures' places.
EyeScore compare_eye(const EyePairs& pairs, const ComparisonOptions& options, const std::function<void()>& done = {});

}  // namespace equistream
