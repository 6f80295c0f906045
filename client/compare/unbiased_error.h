#pragma once
/// Errors without the noise of the truth: the mean of products (A1 - T1)(A2 - T2) whose noises are independent.
///
/// Noise-free error: A1, T1 come from one run, A2, T2 from another. A1 may share noise with T1 and A2 with T2, but
/// nothing of run 1 with anything of run 2. Then D1 = A1 - T1 = e + n1 and D2 = A2 - T2 = e + n2 with independent
/// noises of mean zero, and the mean of D1 D2 has the expectation e^2: the noise adds spread, not bias.
///
/// Whole error: one picture A against two truths, all three independent of each other. D1 = A - T1 and D2 = A - T2 have
/// the same e, which holds A's own noise: the expectation is (A - T)^2, what a viewer gets.
///
/// The interval is that of n1 and n2, for these very pictures; uneven content must not widen it, and noise that
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
#include <filesystem>
#include <vector>

namespace equistream {

inline constexpr int product_block_px = 32;

/// Sums over blocks of one picture position; those of several frames of the same size add up. Empty: of no frame.
struct ProductBlocks {
    std::vector<double> product;    ///< sum of D1 D2 in each block
    std::vector<double> imbalance;  ///< sum of (D1^2 - D2^2) / 2 in each block
    std::int64_t samples = 0;       ///< three a pixel that counts

    void add(const ProductBlocks& other);
};

/// One factor of the product: a picture and its truth, 3 channels. Both factors may have the same picture.
struct PictureAndTruth {
    ImageView<const float> picture;
    ImageView<const float> truth;
};
/// With `mask` (1 channel) only pixels where it is not 0 count.
ProductBlocks product_blocks(const PictureAndTruth& run_1, const PictureAndTruth& run_2,
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
ProductBlocks worst_product_blocks(const PictureAndTruth& run_1, const PictureAndTruth& run_2, double fraction);

/// Mean square error with its 95 % confidence interval. The estimate and its lower end may be negative.
struct UnbiasedError {
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
UnbiasedError unbiased_error(const ProductBlocks& blocks);

// Whether a product is without bias: only where the noise of one picture does not know that of the other. Both throw
// InputError in one line that begins with `option`.

/// Where `play` leaves its report of these views.
std::filesystem::path report_of_views(const std::filesystem::path& view);

struct NoisePair {
    const ScoredPicture &first, &second;
};
/// Refuses pairs of the same file, of the same samples and of the same seed, in this order. Seed and number of samples
/// are the EXR's own, or the source's in the report.json that `play` leaves beside its views; where neither says,
/// nothing is checked. Pictures of one value everywhere hold no noise and may be alike.
void require_independent(const char* option, const std::vector<NoisePair>& pairs);

/// Refuses another number of samples per pixel: the interval holds for noises that are alike.
void require_as_many_samples(const char* option, const ScoredPicture& first, const ScoredPicture& second);

}  // namespace equistream
