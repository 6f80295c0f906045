#pragma once
/// The error of a system freed of render noise, from two independent runs of source and truth.
///
/// A1, T1 come from one run, A2, T2 from another: A1 may share noise with T1 and A2 with T2, but nothing of run 1
/// with anything of run 2. Then D1 = A1 - T1 = e + n1 and D2 = A2 - T2 = e + n2 with independent noises of mean zero,
/// and the mean of D1 D2 has the expectation e^2: the noise adds spread, not bias.
///
/// The interval is that of the *noise*, for these very pictures; uneven content must not widen it, and noise that
/// the filter, the codec or the resampling has smeared over neighbours and over time must not narrow it. Both
/// hold for Y = sum over a block of (D1^2 - D2^2) / 2: whatever e is, Y has mean zero (the runs being alike), and for
/// Gaussian noise of any correlation it has the variance of the block's sum of D1 D2; for noise of heavier tails it
/// has more, so the interval errs on the wide side. Blocks are 32x32 pixels through all frames, beyond which noise
/// is taken as independent, so that the variance of the whole is the sum of Y^2 over blocks. Where nearly all of the
/// error lies in one block there is little to learn the spread from: the interval then holds the truth in some
/// 88 % of cases rather than 95 %.
#include "compared_pictures.h"

#include <equistream/image.h>

#include <cstdint>
#include <vector>

namespace equistream {

inline constexpr int noise_free_block = 32;

/// Sums over blocks of one picture position; those of several frames of the same size add up.
struct NoiseFreeBlocks {
    std::vector<double> product;    ///< sum of D1 D2 in each block
    std::vector<double> imbalance;  ///< sum of (D1^2 - D2^2) / 2 in each block
    std::int64_t samples = 0;       ///< three a pixel that counts

    void add(const NoiseFreeBlocks& other);
};

/// One run's picture and its truth, 3 channels, values in [0, 1].
struct PictureAndTruth {
    ImageView<const float> picture;
    ImageView<const float> truth;
};
/// With `mask` (1 channel) only pixels where it is not 0 count.
NoiseFreeBlocks noise_free_blocks(const PictureAndTruth& run_1, const PictureAndTruth& run_2,
                                  ImageView<const std::uint8_t> mask = {});

/// The worst `fraction` of the pixels, at least one, chosen by one run's difference and scored by its product with the
/// other's: first those where |D1|^2, summed over the channels, is largest, then those where |D2|^2 is; samples and
/// sums of both. Among equals the first in reading order are taken.
///
/// Chosen by D1 a pixel scores e E[D1 | chosen], since n2 knows nothing of the choice. Noise that is chosen where there
/// is no error thus scores 0; where there is one, noise along it is chosen more often than noise against it, so that
/// the score lies between the true square error of these pixels and the geometric mean of that and what PSNR sees.
/// Without noise it is the worst pixels' error exactly. Imbalance errs on the wide side: what one run chooses adds
/// to it and what the other chooses is subtracted.
NoiseFreeBlocks noise_free_worst_blocks(const PictureAndTruth& run_1, const PictureAndTruth& run_2, double fraction);

/// Mean square error with its 95 % confidence interval. The estimate and its lower end may be negative.
struct NoiseFreeError {
    double mean_square = 0;
    double low = 0;
    double high = 0;
    std::int64_t samples = 0;
    std::int64_t blocks = 0;

    /// -10 log10(mean square), peak 1; +inf where it is not positive.
    static double decibels(double mean_square);
    /// The interval reaches 0: all that can be said is "more than decibels(high)".
    bool only_bounded() const { return low <= 0; }
};
NoiseFreeError noise_free_error(const NoiseFreeBlocks& blocks);

// Whether two runs can give a noise-free error: it is one only where the noise of one does not know that of the other.

/// One pair's pictures as read.
struct RunPictures {
    const ScoredPicture &picture, &truth;
};

/// Throws InputError where one file is in both runs.
void require_other_files(const PicturePair& pair);

/// Throws InputError where a picture of run 1 has the samples of one of run 2 or its seed, or where the runs have
/// another number of samples per pixel. Seed and number are the EXR's own, or the source's in the report.json that
/// `play` leaves beside its views; where neither says, nothing is checked. Pictures of one value everywhere hold no
/// noise and may be alike.
void require_independent(const RunPictures& run_1, const RunPictures& run_2);

}  // namespace equistream
