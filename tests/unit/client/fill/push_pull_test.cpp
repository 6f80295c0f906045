#include <tests/unit/client/analytic_scene.h>
#include <tests/unit/client/fill_scene.h>
#include <tests/unit/client/simd_targets.h>
#include <tests/unit/evidence.h>

#include <client/fill/push_pull.h>

#include <equistream/depth_agreement.h>

#include <gtest/gtest.h>

namespace equistream::test {
namespace {

/// One surface above a gap, one below, one to its left and one to its right, each at a distance of its own.
TEST(Background, IsTheFartherEndAlongTheEpipolarLine) {
    constexpr float left_m = 1, right_m = 2, above_m = 3, below_m = 4;
    const PerspectiveCamera camera{9, 7, pi / 2};
    const auto found = [&](int left, int top, int right, int bottom, const glm::dvec3& epipole) {
        EyePicture picture;
        picture.reset(camera);
        picture.depth_m = FloatImage(9, 7, 1);
        for (int y = 0; y < 7; ++y)
            for (int x = 0; x < 9; ++x) {
                const bool is_gap = x >= left && x < right && y >= top && y < bottom;
                *picture.origin.pixel(x, y) = is_gap ? 0 : 1;
                *picture.depth_m.pixel(x, y) = is_gap        ? std::nanf("")
                                               : y < top     ? above_m
                                               : y >= bottom ? below_m
                                               : x < left    ? left_m
                                                             : right_m;
            }
        FloatImage out;
        find_background({camera, {}, {}}, picture, Gaps(picture.origin.view()), epipole, out);
        return out;
    };
    for (int y = 2; y < 5; ++y)
        for (int x = 3; x < 6; ++x) {
            const auto at = [&](const glm::dvec3& epipole) { return *found(3, 2, 6, 5, epipole).pixel(x, y); };
            EXPECT_EQ(at({0, 0, 0}), below_m) << "the largest of all";
            EXPECT_EQ(at({1, 0, 0}), right_m);
            EXPECT_EQ(at({0, 1, 0}), below_m);
            // Before the eye: of pixel (a, b) from the middle |4.5 + 9 a| is held against |9 b|, and so on.
            EXPECT_EQ(at({1, 0, 9}), y == 3 || x == 5 ? right_m : below_m) << x << ' ' << y;
            EXPECT_EQ(at({0, 1, 9}), x != 4 && y >= 3 ? right_m : below_m) << x << ' ' << y;
        }
    EXPECT_EQ(*found(0, 2, 3, 5, {1, 0, 0}).pixel(0, 3), right_m) << "the other end is the picture's border";
    EXPECT_EQ(*found(6, 2, 9, 5, {1, 0, 0}).pixel(8, 3), left_m);
    EXPECT_EQ(*found(0, 3, 9, 4, {1, 0, 0}).pixel(4, 3), below_m) << "no end in its row";
    EXPECT_EQ(*found(4, 0, 5, 7, {0, 1, 0}).pixel(4, 3), right_m) << "none in its column";
    EXPECT_EQ(*found(3, 0, 6, 2, {0, 1, 0}).pixel(4, 0), below_m);
    EXPECT_EQ(*found(3, 5, 6, 7, {0, 1, 0}).pixel(4, 6), above_m);
}

/// The definition in push_pull.h, in double precision, on whole levels.
class PlainPyramid {
public:
    PlainPyramid(const SurfaceDepths& depths, const EyePicture& picture)
        : depths_(depths), picture_(picture), width_(picture.origin.width()), height_(picture.origin.height()) {
        columns_ = (width_ + 7) / 8 * 8;
        rows_ = (height_ + 7) / 8 * 8;
        Level pixels{columns_, rows_, std::vector<Cell>(std::size_t(columns_) * rows_)};
        for (int y = 0; y < height_; ++y)
            for (int x = 0; x < width_; ++x)
                if (counts(x, y))
                    pixels.cells[std::size_t(y) * columns_ + x] = {pixel(x, y)};
        levels_.push_back(std::move(pixels));
        while (levels_.back().columns > 1 || levels_.back().rows > 1)
            levels_.push_back(pull(levels_.back(), levels_.size() <= 3));
        for (std::size_t level = levels_.size() - 1; level-- > 0;)
            push(level);
    }

    /// Colour of a gap, 0 to 255, and whether it has one.
    std::pair<glm::dvec3, bool> at(int x, int y) const {
        const Layer& layer = levels_[0].cells[std::size_t(y) * columns_ + x].at(0);
        return {layer.colour, layer.coloured};
    }

private:
    struct Layer {
        glm::dvec3 colour{0};
        double w = 0;
        bool coloured = false;
    };
    using Cell = std::vector<Layer>;
    struct Level {
        int columns, rows;
        std::vector<Cell> cells;
        const Cell* at(int x, int y) const {
            return x >= 0 && y >= 0 && x < columns && y < rows ? &cells[std::size_t(y) * columns + x] : nullptr;
        }
    };

    bool gap(int x, int y) const { return *picture_.origin.pixel(x, y) == std::uint8_t(PixelOrigin::gap); }
    bool counts(int x, int y) const {
        for (int j = std::max(y / 8 - 1, 0) * 8; j < std::min((y / 8 + 2) * 8, height_); ++j)
            for (int i = std::max(x / 8 - 1, 0) * 8; i < std::min((x / 8 + 2) * 8, width_); ++i)
                if (gap(i, j))
                    return true;
        return false;
    }
    Layer pixel(int x, int y) const {
        const std::uint8_t* c = picture_.rgba.pixel(x, y);
        const ImageView<const float> depth = gap(x, y) ? depths_.gap_m : depths_.known_m;
        double w = 0;
        if (depth.data != nullptr && *depth.pixel(x, y) > 0) {
            const double r = std::min(*depth.pixel(x, y), far_distance_m);
            w = depths_.box_radius_m / std::max(r - depths_.box_radius_m, 1e-3 * r);
        }
        return {{c[0], c[1], c[2]}, w, !gap(x, y)};
    }

    Level pull(const Level& finer, bool exact_halves) const {
        Level level{(finer.columns + 1) / 2, (finer.rows + 1) / 2, {}};
        EXPECT_TRUE(!exact_halves || (finer.columns % 2 == 0 && finer.rows % 2 == 0));
        for (int y = 0; y < level.rows; ++y)
            for (int x = 0; x < level.columns; ++x)
                level.cells.push_back(parent(finer, 2 * x, 2 * y));
        return level;
    }

    Cell parent(const Level& finer, int x, int y) const {
        Cell layers;
        for (int k = 0; k < 4; ++k)
            if (const Cell* child = finer.at(x + k % 2, y + k / 2))
                layers.insert(layers.end(), child->begin(), child->end());
        if (layers.empty())
            return {};
        const auto [low, high] = std::ranges::minmax(layers, {}, &Layer::w);
        const double split = high.w - low.w > depths_.tolerance ? (low.w + high.w) / 2 : infinity;
        Cell cell;
        for (const bool far : {true, false}) {
            Layer mean;
            double present = 0, coloured = 0;
            for (const Layer& layer : layers)
                if ((layer.w <= split) == far) {
                    present += 1;
                    mean.w += layer.w;
                    coloured += layer.coloured;
                    mean.colour += layer.coloured ? layer.colour : glm::dvec3(0);
                }
            mean.w /= std::max(present, 1.0);
            mean.colour /= std::max(coloured, 1.0);
            mean.coloured = coloured > 0;
            if (present > 0)
                cell.push_back(mean);
        }
        return cell;
    }

    void push(std::size_t level) {
        Level& finer = levels_[level];
        for (int y = 0; y < finer.rows; ++y)
            for (int x = 0; x < finer.columns; ++x)
                for (Layer& layer : finer.cells[std::size_t(y) * finer.columns + x])
                    if (!layer.coloured)
                        colour(level + 1, x, y, layer);
    }

    void colour(std::size_t coarser, int x, int y, Layer& layer) const {
        // The place in the coarser level's cells, whose centres are at half-integers.
        const double u = (x + 0.5) / 2 - 0.5, v = (y + 0.5) / 2 - 0.5;
        const int left = int(std::floor(u)), top = int(std::floor(v));
        double sum = 0;
        glm::dvec3 mean(0);
        for (int k = 0; k < 4; ++k) {
            const Cell* cell = levels_[coarser].at(left + k % 2, top + k / 2);
            if (cell == nullptr)
                continue;
            const double bilinear = (1 - std::abs(left + k % 2 - u)) * (1 - std::abs(top + k / 2 - v));
            for (const Layer& from : *cell) {
                const double apart = (from.w - layer.w) / depths_.tolerance;
                const double weight = from.coloured ? bilinear / (1 + apart * apart) : 0;
                sum += weight;
                mean += weight * from.colour;
            }
        }
        layer.coloured = sum > 0;
        if (layer.coloured)
            layer.colour = mean / sum;
    }

    const SurfaceDepths& depths_;
    const EyePicture& picture_;
    int width_, height_, columns_ = 0, rows_ = 0;
    std::vector<Level> levels_;
};

class PushPullOnEveryTarget : public ::testing::TestWithParam<std::int64_t> {};
INSTANTIATE_TEST_SUITE_P(Fill, PushPullOnEveryTarget, ::testing::ValuesIn(targets_here()),
                         [](const auto& target) { return std::string(hwy::TargetName(target.param)); });

TEST_P(PushPullOnEveryTarget, EqualsThePlainPyramid) {
    const OnlyTarget only(GetParam());
    std::mt19937 random(7);
    PushPull pyramid;  // its memory goes from picture to picture
    for (const auto& [width, height] : {std::pair{131, 77}, {64, 64}, {7, 5}, {200, 9}, {1, 1}, {97, 130}}) {
        for (int i = 0; i < 5; ++i) {
            RandomPicture made(width, height, random);
            const SurfaceDepths depths{made.depth_m.view(), made.depth_m.view(), 0.1f, 1e-3f};
            const PlainPyramid plain(depths, made.picture);
            const EyePicture before = made.picture;
            const Gaps gaps(before.origin.view());
            const std::int64_t filled = pyramid.run(depths, gaps, made.picture);
            EXPECT_EQ(made.picture.count(PixelOrigin::push_pull), filled);
            for (int y = 0; y < height; ++y)
                for (int x = 0; x < width; ++x) {
                    const std::uint8_t* is = made.picture.rgba.pixel(x, y);
                    if (*before.origin.pixel(x, y) != 0) {
                        ASSERT_TRUE(std::equal(is, is + 4, before.rgba.pixel(x, y)));
                        continue;
                    }
                    const auto [colour, coloured] = plain.at(x, y);
                    ASSERT_EQ(*made.picture.origin.pixel(x, y) == std::uint8_t(PixelOrigin::push_pull), coloured);
                    for (int c = 0; coloured && c < 3; ++c)
                        // Half a step of rounding, and w in single precision.
                        ASSERT_NEAR(is[c], colour[c], 0.75) << width << "x" << height << ": " << x << ", " << y;
                }
        }
    }
}

TEST(PushPull, WithoutDepthAConstantStaysOneAndARampIsKept) {
    EyePicture picture;
    picture.reset({96, 64, 1});
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 96; ++x)
            if (x < 40 || x >= 52) {
                const std::uint8_t colour[] = {std::uint8_t(2 * x), 77, std::uint8_t(3 * y), 255};
                std::ranges::copy(colour, picture.rgba.pixel(x, y));
                *picture.origin.pixel(x, y) = std::uint8_t(PixelOrigin::source);
            }
    EXPECT_EQ(make_fill_chain("pushpull")[0]->fill({{96, 64, 1}, {}, {}}, picture), 12 * 64);
    for (int y = 8; y < 56; ++y)
        for (int x = 40; x < 52; ++x) {
            EXPECT_NEAR(picture.rgba.pixel(x, y)[0], 2 * x, 12);
            EXPECT_EQ(picture.rgba.pixel(x, y)[1], 77);
            EXPECT_NEAR(picture.rgba.pixel(x, y)[2], 3 * y, 12);
        }
}

TEST(PushPull, NothingToTakeColoursFromLeavesGaps) {
    EyePicture empty;
    empty.reset({40, 30, 1});
    EXPECT_EQ(make_fill_chain("pushpull")[0]->fill({{40, 30, 1}, {}, {}}, empty), 0);
    EXPECT_EQ(empty.count(PixelOrigin::gap), 1200);
}

class PushPullScene : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Depth, PushPullScene, ::testing::Bool());

TEST_P(PushPullScene, TheBackgroundFillsWhatTheForegroundUncovered) {
    FillScene scene;
    if (GetParam())
        scene.forget_eye_depth();
    EXPECT_EQ(scene.fill("pushpull", {.main = &scene.main_view}, PixelOrigin::push_pull), 1);
    // The wall changes by 0.02 a pixel at most; red of the ball would show as 100 and more.
    EXPECT_LE(scene.worst_filled(PixelOrigin::push_pull, GetParam() ? 20 : 0), 26)
        << evidence(scene.picture.rgb().view(), scene.truth.rgb.view());
    if (GetParam()) {
        for (int y = 0; y < 200; ++y)
            for (int x = 0; x < 320; ++x)
                if (*scene.picture.origin.pixel(x, y) == std::uint8_t(PixelOrigin::push_pull)) {
                    EXPECT_GT(*scene.picture.depth_m.pixel(x, y), 1.2f);
                }
    }
}

TEST(Gaps, AreThoseOfThePlainScan) {
    std::mt19937 random(3);
    for (const int width : {1, 7, 8, 9, 33, 64, 100}) {
        ByteImage origin(width, 40, 1);
        for (std::uint8_t& byte : origin.samples())
            byte = random() % 3 == 0 ? std::uint8_t(1 + random() % 255) : 0;
        std::fill_n(origin.pixel(0, 5), width, std::uint8_t{0});
        std::fill_n(origin.pixel(0, 6), width, std::uint8_t{200});
        Gaps gaps(origin.view());
        const auto expect_exact = [&] {
            ByteImage covered(width, 40, 1, 1);
            for (const GapSpan& span : gaps.spans()) {
                EXPECT_LT(span.begin, span.end);
                for (int x = span.begin; x < span.end; ++x)
                    covered.pixel(x, span.y)[0]--;
            }
            for (std::size_t i = 0; i < origin.samples().size(); ++i)
                EXPECT_EQ(covered.samples()[i] == 0, origin.samples()[i] == 0);
        };
        expect_exact();
        for (std::uint8_t& byte : origin.samples())
            byte = byte == 0 && random() % 2 == 0 ? std::uint8_t(255) : byte;
        gaps.narrow(origin.view());
        expect_exact();
        for (const GapSpan& span : gaps.rows(3, 6))
            EXPECT_TRUE(span.y >= 3 && span.y < 6);
    }
}

}  // namespace
}  // namespace equistream::test
