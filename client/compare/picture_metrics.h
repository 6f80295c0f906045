#pragma once
/// Metrics of 8-bit display-referred RGB pictures against a truth of the same size. All functions are pure, use all
/// cores and give the same figure whatever their number. Pictures have 3 channels; masks have 1, non-zero inside.
#include <equistream/conventions.h>
#include <equistream/image.h>

#include <cstdint>
#include <vector>

namespace equistream {

using ErrorPlane = Image<std::uint32_t>;

/// Squared difference of every pixel, summed over R, G and B: 0 to 3 x 255^2.
ErrorPlane squared_errors(ImageView<const std::uint8_t> picture, ImageView<const std::uint8_t> truth);

/// A weighted sum of squared errors in 8-bit units; sums of several frames pool them.
struct ErrorSum {
    double sum = 0;
    double samples = 0;  ///< three a pixel (times its weight)

    double mean_square() const { return samples > 0 ? sum / samples : 0; }
    /// 10 log10(255^2 / mean square); +inf for identical pictures, NaN without samples.
    double psnr_db() const;
    void operator+=(const ErrorSum& other) {
        sum += other.sum;
        samples += other.samples;
    }
};

ErrorSum total_error(const ErrorPlane& errors);
ErrorSum total_error_where(const ErrorPlane& errors, ImageView<const std::uint8_t> mask);
/// Every pixel weighted by the solid angle it covers (WS-PSNR, Sun, Lu and Yu 2017), with this project's exact
/// solid angles rather than cosines.
ErrorSum sphere_error(const ErrorPlane& errors, const LongitudeLatitudeRange& range);

/// Counts pixels by squared error, so that the worst ones of a whole sequence can be found exactly.
class ErrorHistogram {
public:
    ErrorHistogram();
    void add(const ErrorPlane& errors);
    void add(const ErrorHistogram& other);
    /// The worst `fraction` of all pixels counted so far (at least one pixel).
    ErrorSum worst(double fraction) const;

private:
    std::vector<std::int64_t> pixels_;
};

/// Structural similarity of Wang et al. 2004: 11x11 Gaussian window of sigma 1.5, K1 = 0.01, K2 = 0.03, L = 255,
/// population covariance, each of R, G and B on its own; windows that would leave the picture are not counted.
struct SimilaritySum {
    double sum = 0;
    double windows = 0;  ///< three a pixel

    double mean() const { return windows > 0 ? sum / windows : 0; }
    void operator+=(const SimilaritySum& other) {
        sum += other.sum;
        windows += other.windows;
    }
};
struct Similarity {
    SimilaritySum all;
    SimilaritySum masked;  ///< windows centred on a pixel inside the mask
};
inline constexpr int similarity_window = 11;

/// Pictures must be at least similarity_window wide and high. `mask` may be empty (data == nullptr).
Similarity structural_similarity(ImageView<const std::uint8_t> picture, ImageView<const std::uint8_t> truth,
                                 ImageView<const std::uint8_t> mask = {});

}  // namespace equistream
