#include "comparison.h"

#include "flicker.h"

#include <equistream/error.h>
#include <equistream/picture.h>
#include <equistream/sequence.h>
#include <equistream/text.h>

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
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

void make_folder(const std::filesystem::path& folder) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error)
        throw WorkError(folder.string() + ": cannot be made: " + error.message());
}

/// Others' pictures of the same numbers would be replaced: a file says of a folder that its pictures are differences.
void claim(const EyePairs& eye, const std::filesystem::path& folder) {
    if (std::ranges::none_of(eye.pairs, [](const PicturePair& pair) { return pair.frame.has_value(); }))
        return;
    const std::filesystem::path mark = folder / "differences.json";
    std::error_code error;
    if (std::filesystem::exists(folder, error) && !std::filesystem::is_empty(folder, error) &&
        !std::filesystem::exists(mark, error))
        throw InputError(expected_found("--difference " + folder.string(),
                                        "a new folder, or one with " + mark.filename().string() +
                                            ", which says that its pictures are differences",
                                        "a folder without it; remove it or choose another name"));
    make_folder(folder);
    write_file_atomically(mark, formatted("{\"amplified\": %d}\n", difference_gain));
}

void write_difference(const std::filesystem::path& file, ImageView<const std::uint8_t> picture,
                      ImageView<const std::uint8_t> truth) {
    ByteImage difference(picture.width, picture.height, 3);
    for (int y = 0; y < picture.height; ++y)
        for (int i = 0; i < 3 * picture.width; ++i)
            difference.pixel(0, y)[i] = static_cast<std::uint8_t>(
                std::min(255, difference_gain * std::abs(picture.row(y)[i] - truth.row(y)[i])));
    make_folder(file.parent_path());
    write_picture(file, difference.view());
}

struct ScaleBlocks {
    ProductBlocks linear, display;

    void add(const ScaleBlocks& other) {
        linear.add(other.linear);
        display.add(other.display);
    }
    /// Nothing without samples.
    std::optional<ScaleErrors> errors() const {
        if (display.samples == 0)
            return std::nullopt;
        return ScaleErrors{unbiased_error(linear), unbiased_error(display)};
    }
};

/// Of one kind of error.
struct KindBlocks {
    ScaleBlocks all, worst, gaps, flicker;

    void add(const KindBlocks& other) {
        all.add(other.all);
        worst.add(other.worst);
        gaps.add(other.gaps);
        flicker.add(other.flicker);
    }
    UnbiasedErrors errors() const { return {all.errors(), worst.errors(), gaps.errors(), flicker.errors()}; }
};

struct Scale {
    FloatImage (*values_of)(const ScoredPicture&, const DisplayTransform&);
    ProductBlocks ScaleBlocks::*blocks;
};
constexpr std::array scales{Scale{display_values, &ScaleBlocks::display}, Scale{exposed_linear, &ScaleBlocks::linear}};

/// What one pair contributes besides its score.
struct FrameSums {
    FrameScore score;
    KindBlocks whole, noise_free;
    std::optional<bool> flicker_by_motion;  ///< nothing where no frame before it is compared
    int width = 0;
    int height = 0;
};

/// One pair's pictures as read; of a second run, and of a second truth, what there is.
struct PairPictures {
    ScoredPicture picture, truth;
    std::optional<ScoredPicture> second_picture, second_truth;
};

/// The same on one scale, or what changes of it; empty where there is no such picture.
struct PairValues {
    FloatImage picture, truth, second_picture, second_truth;
};

class PairMeasurement {
public:
    PairMeasurement(const EyePairs& eye, const ComparisonOptions& options)
        : eye_(eye), options_(options), transform_(options.view) {}

    /// `before`: the pair of the frame before, where flicker is to be measured; else none.
    FrameSums measure(const PicturePair& pair, const PicturePair* before, Histograms& histograms) const {
        const PairPictures pictures = read(pair);
        const auto& [picture, truth, second_picture, second_truth] = pictures;
        FrameSums sums;
        sums.width = truth.width();
        sums.height = truth.height();
        const ByteImage mask = read_gaps(pair, sums.width, sums.height);
        // Floats of whole pictures are made only where a second truth asks for them.
        ByteImage made, made_of_truth;
        const MaskedPair masked{display_8bit(picture, transform_, made), display_8bit(truth, transform_, made_of_truth),
                                mask};
        sums.score = score_8bit(pair, truth, masked, histograms);
        if (second_truth)
            add_products(pictures, mask, before, sums);
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

    /// All as large as the truth.
    PairPictures read(const PicturePair& pair) const {
        PairPictures pictures;
        pictures.truth = read_scored_picture(pair.truth, options_.exposure, options_.flicker);
        const auto read_one = [&](const std::filesystem::path& file) {
            ScoredPicture picture = read_scored_picture(file, options_.exposure);
            require_size(file, picture.width(), picture.height(), pictures.truth.width(), pictures.truth.height());
            return picture;
        };
        pictures.picture = read_one(pair.picture);
        if (!pair.second_picture.empty())
            pictures.second_picture = read_one(pair.second_picture);
        if (!pair.second_truth.empty())
            pictures.second_truth = read_one(pair.second_truth);
        return pictures;
    }

    /// Pictures whose noises must be independent are.
    void require_products(const PairPictures& pictures) const {
        const auto& [picture, truth, second_picture, second_truth] = pictures;
        if (second_picture) {
            require_independent("--second", {{picture, *second_picture},
                                             {picture, *second_truth},
                                             {truth, *second_picture},
                                             {truth, *second_truth}});
            require_as_many_samples("--second", picture, *second_picture);
            require_as_many_samples("--second", truth, *second_truth);
        }
        if (options_.whole) {
            require_independent("--truth2", {{truth, *second_truth}, {truth, picture}, {*second_truth, picture}});
            require_as_many_samples("--truth2", truth, *second_truth);
        }
    }

    PairValues values_of(const PairPictures& pictures, const Scale& scale) const {
        const auto of = [&](const std::optional<ScoredPicture>& picture) {
            return picture ? scale.values_of(*picture, transform_) : FloatImage();
        };
        return {scale.values_of(pictures.picture, transform_), scale.values_of(pictures.truth, transform_),
                of(pictures.second_picture), of(pictures.second_truth)};
    }

    /// Calls add(blocks of a kind, one factor, the other factor) for each kind of error that is measured.
    template <typename Add>
    void for_each_kind(const PairValues& values, FrameSums& sums, const Add& add) const {
        const PictureAndTruth first{values.picture.view(), values.truth.view()};
        if (options_.whole)
            add(sums.whole, first, PictureAndTruth{values.picture.view(), values.second_truth.view()});
        if (!values.second_picture.empty())
            add(sums.noise_free, first, PictureAndTruth{values.second_picture.view(), values.second_truth.view()});
    }

    void add_products(const PairPictures& pictures, const ByteImage& mask, const PicturePair* before_it,
                      FrameSums& sums) const {
        require_products(pictures);
        std::optional<PairPictures> before;
        std::optional<PastPixels> past;
        if (before_it) {
            before = read(*before_it);
            require_size(before_it->truth, before->truth.width(), before->truth.height(), sums.width, sums.height);
            past.emplace(pictures.truth, before->truth);
            sums.flicker_by_motion = past->by_motion();
        }
        for (const Scale& scale : scales) {
            const PairValues values = values_of(pictures, scale);
            for_each_kind(values, sums,
                          [&](KindBlocks& kind, const PictureAndTruth& one, const PictureAndTruth& other) {
                              kind.all.*scale.blocks = product_blocks(one, other);
                              kind.worst.*scale.blocks = worst_product_blocks(one, other, worst_fraction);
                              if (!mask.empty())
                                  kind.gaps.*scale.blocks = product_blocks(one, other, mask.view());
                          });
            if (!before)
                continue;
            const PairValues then = values_of(*before, scale);
            const auto change = [&](FloatImage PairValues::*picture) {
                return (values.*picture).empty() ? FloatImage() : past->change(values.*picture, then.*picture);
            };
            const PairValues changes{change(&PairValues::picture), change(&PairValues::truth),
                                     change(&PairValues::second_picture), change(&PairValues::second_truth)};
            for_each_kind(changes, sums,
                          [&](KindBlocks& kind, const PictureAndTruth& one, const PictureAndTruth& other) {
                              kind.flicker.*scale.blocks = product_blocks(one, other, past->seen());
                          });
        }
    }

    const EyePairs& eye_;
    const ComparisonOptions& options_;
    DisplayTransform transform_;
};

/// All frames of one eye, added in their order: sums are then the same to the last bit whatever was ready first.
class EyeTotal {
public:
    explicit EyeTotal(const EyePairs& eye) : eye_(eye) { score_.eye = eye.eye; }

    void add(const FrameSums& frame) {
        const std::string truth = eye_.pairs[score_.frames.size()].truth.string();
        if (score_.frames.empty()) {
            score_.width = frame.width;
            score_.height = frame.height;
        }
        require_size(truth, frame.width, frame.height, score_.width, score_.height);
        const std::optional<bool> by = frame.flicker_by_motion;
        if (by && by_motion_.value_or(*by) != *by)
            throw InputError(
                expected_found(truth, "motion AOVs in all frames or in none",
                               *by ? "some, and none in the frames before" : "none, but some in the frames before"));
        by_motion_ = by ? by : by_motion_;
        score_.frames.push_back(frame.score);
        score_.pooled.error += frame.score.error;
        score_.pooled.gap_error += frame.score.gap_error;
        score_.pooled.sphere_error += frame.score.sphere_error;
        score_.pooled.similarity.all += frame.score.similarity.all;
        score_.pooled.similarity.masked += frame.score.similarity.masked;
        whole_.add(frame.whole);
        noise_free_.add(frame.noise_free);
    }

    EyeScore score(const Histograms& histograms) {
        ErrorHistogram histogram;
        for (const ErrorHistogram& part : histograms)
            histogram.add(part);
        score_.worst_pixels = histogram.worst(worst_fraction);
        score_.whole = whole_.errors();
        score_.noise_free = noise_free_.errors();
        score_.flicker_by_motion = by_motion_.value_or(false);
        return std::move(score_);
    }

private:
    const EyePairs& eye_;
    EyeScore score_;
    KindBlocks whole_, noise_free_;
    std::optional<bool> by_motion_;
};

bool is_exr(const std::filesystem::path& file) {
    return file.extension() == ".exr";
}

/// About, at its most: each picture as it was read, one scale's floats of it, its 8 bits and what is made of these.
std::int64_t bytes_of(const PicturePair& pair, std::int64_t pixels, bool with_flicker) {
    const bool is_linear = is_exr(pair.picture) || is_exr(pair.truth);
    const bool has_floats = is_linear || !pair.second_truth.empty();
    const int bytes_a_pixel = (is_linear ? 16 : 3) + (has_floats ? 12 : 0) + 8;
    const int pictures = 2 + !pair.second_picture.empty() + !pair.second_truth.empty();
    return pixels * bytes_a_pixel * pictures * (with_flicker ? 2 : 1);  // with those of the frame before
}

/// At most as many as there are threads: each pair uses all that are free.
std::size_t pairs_at_once(const EyePairs& eye, const ComparisonOptions& options) {
    if (eye.pairs.size() < 2)
        return 1;
    const PicturePair& pair = eye.pairs.front();
    const ScoredPicture truth = read_scored_picture(pair.truth);  // all have its size
    const std::int64_t bytes = bytes_of(pair, std::int64_t{truth.width()} * truth.height(), options.flicker);
    return std::size_t(
        std::clamp<std::int64_t>(options.bytes_at_once / bytes, 1, tbb::this_task_arena::max_concurrency()));
}

}  // namespace

double EyeScore::mean_frame_psnr_db() const {
    double sum = 0;
    int differing = 0;
    for (const FrameScore& frame : frames)
        if (const double db = frame.error.psnr_db(); !std::isinf(db)) {
            sum += db;
            ++differing;
        }
    if (differing > 0)
        return sum / differing;
    return frames.empty() ? std::numeric_limits<double>::quiet_NaN() : std::numeric_limits<double>::infinity();
}

EyeScore compare_eye(const EyePairs& eye, const ComparisonOptions& options, const std::function<void()>& done) {
    if (!options.difference_folder.empty()) {
        require_apart(eye, options.difference_folder);
        claim(eye, options.difference_folder);
    }
    const PairMeasurement measurement(eye, options);
    EyeTotal total(eye);
    Histograms histograms;
    std::size_t chosen = 0;
    const auto choose = [&](tbb::flow_control& control) -> std::size_t {
        if (chosen < eye.pairs.size())
            return chosen++;
        control.stop();
        return 0;
    };
    const auto measure = [&](std::size_t i) {
        const PicturePair& pair = eye.pairs[i];
        const bool follows = options.flicker && i > 0 && pair.frame && *pair.frame == *eye.pairs[i - 1].frame + 1;
        FrameSums sums = measurement.measure(pair, follows ? &eye.pairs[i - 1] : nullptr, histograms);
        if (done)
            done();
        return sums;
    };
    const auto add = [&](const FrameSums& sums) { total.add(sums); };
    constexpr auto in_order = tbb::filter_mode::serial_in_order;
    tbb::parallel_pipeline(pairs_at_once(eye, options), tbb::make_filter<void, std::size_t>(in_order, choose),
                           tbb::make_filter<std::size_t, FrameSums>(tbb::filter_mode::parallel, measure),
                           tbb::make_filter<FrameSums, void>(in_order, add));
    return total.score(histograms);
}

}  // namespace equistream
