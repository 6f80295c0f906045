#include "comparison.h"

#include <equistream/error.h>
#include <equistream/picture.h>
#include <equistream/sequence.h>
#include <equistream/text.h>

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace equistream {

namespace {

/// One a thread: counts add up to the same whatever thread counted them.
using Histograms = tbb::enumerable_thread_specific<ErrorHistogram>;

void require_size(const std::filesystem::path& file, int width, int height, int expected_width, int expected_height) {
    if (width != expected_width || height != expected_height)
        throw InputError(expected_found(file.string(), size_text(expected_width, expected_height) + " pixels",
                                        size_text(width, height)));
}

/// The range of an equirect picture: an EXR knows it, a PNG is taken for a full sphere.
LongitudeLatitudeRange sphere_range(const ScoredPicture& picture) {
    if (!picture.info)
        return {};
    const auto* camera = std::get_if<EquirectCamera>(&picture.info->camera);
    if (!camera)
        throw InputError(expected_found(picture.file.string(), "an equirect picture for ws-psnr", "a perspective one"));
    return camera->range;
}

std::filesystem::path difference_file(const PicturePair& pair, const std::string& eye,
                                      const std::filesystem::path& folder) {
    const std::string name =
        pair.frame ? frame_file_name(*pair.frame, "png") : pair.picture.stem().string() + ".difference.png";
    return (eye == "view" ? folder : folder / eye) / name;
}

/// Difference pictures have the names of frames: among those that are compared they would take their places.
void require_apart(const EyePairs& eye, const std::filesystem::path& folder) {
    for (const PicturePair& pair : eye.pairs) {
        const std::filesystem::path file = difference_file(pair, eye.eye, folder);
        for (const auto& input : {pair.picture, pair.truth, pair.second_picture, pair.second_truth, pair.gaps}) {
            std::error_code error;  // what is not there is not compared
            if (pair.frame ? std::filesystem::equivalent(file.parent_path(), input.parent_path(), error)
                           : std::filesystem::equivalent(file, input, error))
                throw InputError(expected_found("--difference " + folder.string(),
                                                "a folder apart from what is compared", input.string()));
        }
    }
}

void write_difference(const std::filesystem::path& file, ImageView<const std::uint8_t> picture,
                      ImageView<const std::uint8_t> truth) {
    ByteImage difference(picture.width, picture.height, 3);
    for (int y = 0; y < picture.height; ++y)
        for (int i = 0; i < 3 * picture.width; ++i)
            difference.pixel(0, y)[i] = static_cast<std::uint8_t>(
                std::min(255, difference_gain * std::abs(picture.row(y)[i] - truth.row(y)[i])));
    std::error_code error;
    std::filesystem::create_directories(file.parent_path(), error);
    if (error)
        throw WorkError(file.parent_path().string() + ": cannot be made: " + error.message());
    write_picture(file, difference.view());
}

struct BothBlocks {
    NoiseFreeBlocks linear, display;

    void add(const BothBlocks& other) {
        linear.add(other.linear);
        display.add(other.display);
    }
    /// Nothing without samples.
    std::optional<NoiseFreeErrors> errors() const {
        if (display.samples == 0)
            return std::nullopt;
        return NoiseFreeErrors{noise_free_error(linear), noise_free_error(display)};
    }
};

/// What one pair contributes besides its score.
struct FrameSums {
    FrameScore score;
    BothBlocks all, worst, gaps;
    int width = 0;
    int height = 0;
};

class PairMeasurement {
public:
    PairMeasurement(const EyePairs& eye, const ComparisonOptions& options)
        : eye_(eye), options_(options), transform_(options.view) {}

    FrameSums measure(const PicturePair& pair, Histograms& histograms) const {
        const ScoredPicture picture = read_scored_picture(pair.picture, options_.exposure);
        const ScoredPicture truth = read_scored_picture(pair.truth, options_.exposure);
        FrameSums sums;
        sums.width = truth.width();
        sums.height = truth.height();
        require_size(pair.picture, picture.width(), picture.height(), sums.width, sums.height);
        const ByteImage mask = read_gaps(pair, sums.width, sums.height);
        // Floats of whole pictures are made only where a second run asks for them.
        ByteImage made, made_of_truth;
        const MaskedPair masked{display_8bit(picture, transform_, made), display_8bit(truth, transform_, made_of_truth),
                                mask};
        sums.score = score_8bit(pair, truth, masked, histograms);
        if (!pair.second_picture.empty())
            compare_runs(pair, {picture, truth, mask}, sums);
        return sums;
    }

private:
    struct MaskedPair {
        ImageView<const std::uint8_t> picture, truth;
        const ByteImage& mask;  ///< empty without gap masks
    };

    static ByteImage read_gaps(const PicturePair& pair, int width, int height) {
        if (pair.gaps.empty())
            return {};
        ByteImage mask = read_mask(pair.gaps);
        require_size(pair.gaps, mask.width(), mask.height(), width, height);
        return mask;
    }

    FrameScore score_8bit(const PicturePair& pair, const ScoredPicture& truth_file, const MaskedPair& masked,
                          Histograms& histograms) const {
        const auto& [picture, truth, mask] = masked;
        FrameScore score;
        score.frame = pair.frame;
        const ErrorPlane errors = squared_errors(picture, truth);
        score.error = total_error(errors);
        histograms.local().add(errors);
        if (!mask.empty())
            score.gap_error = total_error_where(errors, mask.view());
        if (options_.sphere_psnr)
            score.sphere_error = sphere_error(errors, sphere_range(truth_file));
        if (options_.ssim) {
            if (std::min(truth.width, truth.height) < similarity_window)
                throw InputError(expected_found(pair.truth.string(), "at least 11x11 pixels for ssim",
                                                size_text(truth.width, truth.height)));
            score.similarity =
                structural_similarity(picture, truth, mask.empty() ? ImageView<const std::uint8_t>{} : mask.view());
        }
        if (!options_.difference_folder.empty())
            write_difference(difference_file(pair, eye_.eye, options_.difference_folder), picture, truth);
        return score;
    }

    struct FirstRun {
        const ScoredPicture& picture;
        const ScoredPicture& truth;
        const ByteImage& mask;
    };

    void compare_runs(const PicturePair& pair, const FirstRun& first, FrameSums& sums) const {
        const ScoredPicture second = read_scored_picture(pair.second_picture, options_.exposure);
        const ScoredPicture second_truth = read_scored_picture(pair.second_truth, options_.exposure);
        require_size(pair.second_picture, second.width(), second.height(), sums.width, sums.height);
        require_size(pair.second_truth, second_truth.width(), second_truth.height(), sums.width, sums.height);
        require_independent({first.picture, first.truth}, {second, second_truth});
        const auto compare = [&](const auto& values_of, NoiseFreeBlocks BothBlocks::*values) {
            const FloatImage one = values_of(first.picture, transform_), true_one = values_of(first.truth, transform_);
            const FloatImage two = values_of(second, transform_), true_two = values_of(second_truth, transform_);
            const PictureAndTruth run_1{one.view(), true_one.view()}, run_2{two.view(), true_two.view()};
            sums.all.*values = noise_free_blocks(run_1, run_2);
            sums.worst.*values = noise_free_worst_blocks(run_1, run_2, worst_fraction);
            if (!first.mask.empty())
                sums.gaps.*values = noise_free_blocks(run_1, run_2, first.mask.view());
        };
        compare(display_values, &BothBlocks::display);
        compare(exposed_linear, &BothBlocks::linear);
    }

    const EyePairs& eye_;
    const ComparisonOptions& options_;
    DisplayTransform transform_;
};

}  // namespace

double EyeScore::mean_frame_psnr_db() const {
    double sum = 0;
    for (const FrameScore& frame : frames)
        sum += frame.error.psnr_db();
    return frames.empty() ? std::numeric_limits<double>::quiet_NaN() : sum / static_cast<double>(frames.size());
}

EyeScore compare_eye(const EyePairs& eye, const ComparisonOptions& options, const std::function<void()>& done) {
    for (const PicturePair& pair : eye.pairs)
        if (!pair.second_picture.empty())
            require_other_files(pair);
    if (!options.difference_folder.empty())
        require_apart(eye, options.difference_folder);
    const PairMeasurement measurement(eye, options);
    std::vector<FrameSums> frames(eye.pairs.size());
    Histograms histograms;
    tbb::parallel_for(std::size_t{0}, eye.pairs.size(), [&](std::size_t i) {
        frames[i] = measurement.measure(eye.pairs[i], histograms);
        if (done)
            done();
    });

    EyeScore score;
    score.eye = eye.eye;
    score.width = frames.front().width;
    score.height = frames.front().height;
    ErrorHistogram histogram;
    BothBlocks all, worst, gaps;
    for (std::size_t i = 0; i < frames.size(); ++i) {
        const FrameSums& frame = frames[i];
        require_size(eye.pairs[i].truth, frame.width, frame.height, score.width, score.height);
        score.frames.push_back(frame.score);
        score.pooled.error += frame.score.error;
        score.pooled.gap_error += frame.score.gap_error;
        score.pooled.sphere_error += frame.score.sphere_error;
        score.pooled.similarity.all += frame.score.similarity.all;
        score.pooled.similarity.masked += frame.score.similarity.masked;
        all.add(frame.all);
        worst.add(frame.worst);
        gaps.add(frame.gaps);
    }
    for (const ErrorHistogram& part : histograms)
        histogram.add(part);
    score.worst_pixels = histogram.worst(worst_fraction);
    score.noise_free = all.errors();
    score.worst_noise_free = worst.errors();
    score.gaps_noise_free = gaps.errors();
    return score;
}

}  // namespace equistream
