#include <equistream/bound.h>
#include <equistream/depth_code.h>
#include <equistream/error.h>

#include <tests/support/planes.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace equistream {
namespace {

constexpr float inf = std::numeric_limits<float>::infinity();
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

constexpr DepthCodeId all_codes[] = {DepthCodeId::pece444, DepthCodeId::pece420, DepthCodeId::hue,     DepthCodeId::w8,
                                     DepthCodeId::w10,     DepthCodeId::w12,     DepthCodeId::lossless};

/// x spread evenly and by chance, both ends, and what is nearer than near.
FloatImage depths(const DepthRange& range, int width, int height, unsigned seed) {
    FloatImage depth_m(width, height, 1);
    std::mt19937 generator(seed);
    std::uniform_real_distribution<double> uniform(0, 1);
    const auto samples = depth_m.samples();
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const double x = i % 2 == 0 ? double(i) / double(samples.size()) : uniform(generator);
        samples[i] = float(range.box_radius_m + (range.near_m - range.box_radius_m) / x);
    }
    samples[0] = inf;
    samples[1] = float(range.near_m);
    return depth_m;
}

/// What rounding alone changes of w at most: all that changes where the pixels that share a sample are of one depth.
double rounding_w(const DepthCode& code, const DepthRange& range) {
    const int levels = code.levels(range);
    return levels == 0 ? 0 : bounded_inverse_depth(range.near_m, range.box_radius_m) / (2 * levels);
}

/// A chroma sample of 4:2:0 stands for four pixels.
FloatImage in_squares_of_four(const FloatImage& depth_m) {
    FloatImage squares(2 * depth_m.width(), 2 * depth_m.height(), 1);
    for (int y = 0; y < squares.height(); ++y)
        for (int x = 0; x < squares.width(); ++x)
            squares.pixel(x, y)[0] = depth_m.pixel(x / 2, y / 2)[0];
    return squares;
}

FloatImage round_trip(const DepthCode& code, const FloatImage& depth_m, const DepthRange& range,
                      std::int64_t* too_near = nullptr) {
    Planes planes(code.format(), depth_m.width(), depth_m.height());
    const std::int64_t count = code.pack(depth_m.view(), range, planes.view());
    if (too_near != nullptr)
        *too_near = count;
    FloatImage back(depth_m.width(), depth_m.height(), 1, -1.0f);
    code.unpack(planes.view(), range, back.view());
    return back;
}

double worst_error_w(const FloatImage& depth_m, const FloatImage& back_m, double box_radius_m) {
    double worst = 0;
    for (std::size_t i = 0; i < back_m.samples().size(); ++i)
        worst = std::max(worst, std::abs(bounded_inverse_depth(depth_m.samples()[i], box_radius_m) -
                                         bounded_inverse_depth(back_m.samples()[i], box_radius_m)));
    return worst;
}

class EveryCode : public testing::TestWithParam<DepthCodeId> {
protected:
    std::unique_ptr<DepthCode> code = make_depth_code(GetParam());
};

TEST_P(EveryCode, RoundTripStaysWithinTheStep) {
    for (const bool has_empty : {false, true})
        for (const auto& [box, near] : {std::pair{0.0315, 0.3}, {0.063, 0.1}, {0.2815, 0.75}, {0.0315, 40.0}}) {
            const DepthRange range{box, double(float(near)), has_empty};
            const FloatImage unlike_m = depths(range, 128, 64, 7), alike_m = in_squares_of_four(unlike_m);
            // Floats near infinity: w has its own rounding, of a depth's last bit.
            const double last_bit =
                GetParam() == DepthCodeId::lossless ? 0 : 4e-7 * bounded_inverse_depth(range.near_m, box);
            const double worst = worst_error_w(alike_m, round_trip(*code, alike_m, range), box);
            const double rounding = rounding_w(*code, range);
            EXPECT_LE(worst, rounding + last_bit) << "B " << box << ", near " << near;
            EXPECT_GE(worst, 0.5 * rounding);  // no larger than it has to be
            EXPECT_LE(worst_error_w(unlike_m, round_trip(*code, unlike_m, range), box),
                      std::sin(quantisation_bound_rad(*code, range)) + last_bit);
        }
}

TEST_P(EveryCode, InfinityAndTheNearestDepthComeBackAsTheyWere) {
    const DepthRange range{0.0315, double(0.3f), false};
    FloatImage depth_m(64, 4, 1, inf);
    for (float& r : depth_m.samples().subspan(128))
        r = 0.3f;
    const FloatImage back = round_trip(*code, depth_m, range);
    EXPECT_EQ(depth_tolerance_w(DepthCodeInfo{code->id(), range}), std::sin(quantisation_bound_rad(*code, range)));
    const double step = 2 * rounding_w(*code, range);
    for (int x = 0; x < 64; ++x) {
        EXPECT_EQ(back.pixel(x, 0)[0], inf);
        EXPECT_NEAR(bounded_inverse_depth(back.pixel(x, 3)[0], 0.0315), bounded_inverse_depth(0.3f, 0.0315), step);
    }
}

TEST_P(EveryCode, WhatIsNearerIsClampedAndCounted) {
    const DepthRange range{0.0315, 0.5, false};
    FloatImage depth_m(64, 4, 1, 2.0f);
    const float nearer[] = {0.49f, 0.1f, 0.0315f, 0.01f, 0.0f};
    for (std::size_t i = 0; i < 64; ++i)
        depth_m.samples()[i] = nearer[i % 5];
    for (std::size_t i = 64; i < 128; ++i)
        depth_m.samples()[i] = 0.5f;
    std::int64_t too_near = 0;
    const FloatImage back = round_trip(*code, depth_m, range, &too_near);
    if (GetParam() == DepthCodeId::lossless) {
        EXPECT_EQ(too_near, 0);
        EXPECT_EQ(back.samples()[0], 0.49f);
        return;
    }
    EXPECT_EQ(too_near, 64);
    const double step = 2 * rounding_w(*code, range);
    for (std::size_t i = 0; i < 64; ++i)
        EXPECT_NEAR(bounded_inverse_depth(back.samples()[i], 0.0315), bounded_inverse_depth(0.5, 0.0315), step);
}

TEST_P(EveryCode, PixelsWithoutASurfaceStayThatAndOthersNever) {
    const DepthRange range{0.0315, 0.5, true};
    FloatImage depth_m = depths(range, 128, 32, 3);
    for (int y = 0; y < 32; ++y)  // squares of two rows and columns, for 4:2:0
        for (int x = 0; x < 128; ++x)
            if ((x / 4 + y / 4) % 3 == 0)
                depth_m.pixel(x, y)[0] = nan;
    const FloatImage back = round_trip(*code, depth_m, range);
    for (std::size_t i = 0; i < back.samples().size(); ++i)
        EXPECT_EQ(std::isnan(back.samples()[i]), std::isnan(depth_m.samples()[i])) << i;

    const DepthRange without{0.0315, 0.5, false};
    if (GetParam() == DepthCodeId::lossless)
        return;
    const FloatImage with_surfaces = round_trip(*code, depth_m, without);
    for (const float r : with_surfaces.samples())
        EXPECT_FALSE(std::isnan(r));
}

TEST_P(EveryCode, AnySamplesGiveADepthOfTheRange) {
    std::mt19937 generator(5);
    const PlaneFormat format = code->format();
    for (const bool has_empty : {false, true}) {
        const DepthRange range{0.0315, 0.5, has_empty};
        Planes planes(format, 128, 64);
        const PlanesView view = planes.view();
        for (int i = 0; i < format.plane_count(); ++i)
            for (int y = 0; y < 64 / format.step(i); ++y)
                for (int x = 0; x < 128 / format.step(i); ++x)
                    if (format.bits == 8)
                        view.bytes[i].row(y)[x] = std::uint8_t(generator());
                    else
                        view.words[i].row(y)[x] = std::uint16_t(generator());  // also beyond the format's bits
        FloatImage back(128, 64, 1, -1.0f);
        code->unpack(planes.view(), range, back.view());
        const bool is_lossless = GetParam() == DepthCodeId::lossless;           // any bits are a depth
        const bool may_be_empty = has_empty || GetParam() == DepthCodeId::hue;  // grey has no hue
        for (const float r : back.samples()) {
            EXPECT_TRUE(r >= 0.5f || (std::isnan(r) && may_be_empty) || is_lossless) << r;
            EXPECT_FALSE(std::signbit(r) && !std::isnan(r));
        }
    }
}

INSTANTIATE_TEST_SUITE_P(DepthCode, EveryCode, testing::ValuesIn(all_codes),
                         [](const auto& tested) { return std::string(depth_code_name(tested.param)); });

TEST(DepthCode, PeceDecodesAsThePaperSays) {
    // The paper's own formulas, in real numbers, on 8-bit luma that counts steps of 1/256 and 8-bit waves.
    const auto code = make_depth_code("pece444");
    const DepthRange range{0.0315, 0.5, false};
    const double w = 65536, p = 512 / w;
    std::mt19937 generator(11);
    Planes planes(code->format(), 64, 2);
    FloatImage depth_m(64, 2, 1);
    for (int round = 0; round < 200; ++round) {
        const double d = 1 + double(generator() % 65406);
        const double l = std::round(d / 256) / 256;
        const auto wave = [&](double at) {
            const double m = std::fmod(at / (p / 2) + 4, 2);
            return std::round(255 * (m <= 1 ? m : 2 - m)) / 255;
        };
        const double ha = wave(d / w), hb = wave(d / w - p / 4);
        const int m = (int(std::floor(4 * l / p - 0.5)) % 4 + 4) % 4;
        const double l0 = l - (std::fmod(l - p / 8 + p, p)) + p / 4 * m - p / 8;
        const double delta = p / 2 * (m == 0 ? ha : m == 1 ? hb : m == 2 ? 1 - ha : 1 - hb);
        const double decoded = std::max(w * (l0 + delta), 0.0);

        const PlanesView view = planes.view();
        view.bytes[0].row(0)[0] = std::uint8_t(std::lround(256 * l));
        view.bytes[1].row(0)[0] = std::uint8_t(std::lround(255 * ha));
        view.bytes[2].row(0)[0] = std::uint8_t(std::lround(255 * hb));
        code->unpack(planes.view(), range, depth_m.view());
        const double x = (0.5 - 0.0315) / (double(depth_m.samples()[0]) - 0.0315);
        EXPECT_NEAR(x * 65407, decoded, 0.02) << d;
        EXPECT_NEAR(decoded, d, 0.51) << d;
    }
}

/// Depths of the middle of a range, told by the steps that Pece's codes count them in.
class PeceBounds : public testing::Test {
protected:
    static constexpr DepthRange range{0.03125, 0.5, false};
    static constexpr double top = 65407;

    static double steps_of(float depth_m) {
        return top * (range.near_m - range.box_radius_m) / (double(depth_m) - range.box_radius_m);
    }
    static float depth_of(double steps) {
        return float(range.box_radius_m + top * (range.near_m - range.box_radius_m) / steps);
    }
    static double bound_steps(const DepthCode& code) {
        return top * std::sin(quantisation_bound_rad(code, range)) /
               bounded_inverse_depth(range.near_m, range.box_radius_m);
    }
    static double worst_steps(const DepthCode& code, const FloatImage& depth_m) {
        const FloatImage back_m = round_trip(code, depth_m, range);
        double worst = 0;
        for (std::size_t i = 0; i < back_m.samples().size(); ++i)
            worst = std::max(worst, std::abs(steps_of(back_m.samples()[i]) - steps_of(depth_m.samples()[i])));
        return worst;
    }
};

/// 128 of 256 steps up its wave a depth is 127.5 of 255: both are rounded up.
TEST_F(PeceBounds, CountBothRoundings) {
    const auto code = make_depth_code(DepthCodeId::pece444);
    FloatImage depth_m(64, 2, 1);
    for (std::size_t i = 0; i < depth_m.samples().size(); ++i)
        depth_m.samples()[i] = depth_of(256 + 512 * double(i % 4) - 0.499);
    const double worst = worst_steps(*code, depth_m);
    EXPECT_LE(worst, bound_steps(*code));
    EXPECT_GE(worst, 0.998 * bound_steps(*code));
}

/// One at the foot of its wave, and three at the top.
TEST_F(PeceBounds, CountThePixelsThatShareASample) {
    const auto code = make_depth_code(DepthCodeId::pece420);
    FloatImage depth_m(64, 2, 1, depth_of(384));
    for (int x = 0; x < 64; x += 2)
        depth_m.pixel(x, 0)[0] = depth_of(127.501);
    const double worst = worst_steps(*code, depth_m);
    EXPECT_LE(worst, bound_steps(*code));
    EXPECT_GE(worst, 0.99 * bound_steps(*code));
}

TEST(DepthCode, RangesHoldTheNearestSurfaceWithinTheWholeBudget) {
    for (const DepthCodeId id : all_codes) {
        const auto code = make_depth_code(id);
        for (const bool has_empty : {false, true}) {
            for (const double nearest : {0.02, 0.04, 0.1, 0.3, 1.0, 30.0}) {
                const DepthRange range = depth_range(*code, 0.0315, nearest, has_empty, 960);
                EXPECT_EQ(range.has_empty, has_empty);
                EXPECT_GE(range.near_m, nearest);
                EXPECT_GT(float(range.near_m), float(range.box_radius_m));
                EXPECT_LE(std::asin(rounding_w(*code, range)), error_budget_rad(960) * (1 + 1e-6));
            }
            EXPECT_EQ(depth_range(*code, 0.0315, 30, has_empty, 960).near_m, 30);
            EXPECT_TRUE(std::isfinite(depth_range(*code, 0.0315, HUGE_VAL, has_empty, 960).near_m));
        }
    }
}

TEST(DepthCode, TheBoundChoosesNoMoreBitsThanItNeeds) {
    const double quarter = error_budget_rad(960) / 4;
    for (const bool has_empty : {false, true})
        for (const auto& [box, nearest] :
             {std::pair{0.0315, 20.0}, {0.0315, 9.0}, {0.0315, 1.0}, {0.063, 0.3}, {0.2815, 0.5}}) {
            const DepthCodeId id = code_for_bound(box, nearest, has_empty, 960);
            const auto bound = [&](DepthCodeId code) {
                return quantisation_bound_rad(*make_depth_code(code), {box, nearest, has_empty});
            };
            EXPECT_TRUE(id == DepthCodeId::w12 || bound(id) <= quarter);
            if (id == DepthCodeId::w8)
                continue;
            EXPECT_GT(bound(id == DepthCodeId::w12 ? DepthCodeId::w10 : DepthCodeId::w8), quarter);
        }
    EXPECT_EQ(code_for_bound(0.0315, 20, false, 960), DepthCodeId::w8);
    EXPECT_EQ(code_for_bound(0.0315, 0.5, false, 960), DepthCodeId::w10);
    EXPECT_EQ(code_for_bound(0.2815, 0.5, false, 960), DepthCodeId::w12);
}

TEST(DepthCode, UnknownNamesListTheKnown) {
    try {
        make_depth_code("w16");
        FAIL();
    } catch (const InputError& error) {
        EXPECT_STREQ(error.what(), "depth code: expected one of pece444, pece420, hue, w8, w10, w12, lossless, found "
                                   "'w16'");
    }
    for (const std::string_view name : depth_code_names())
        EXPECT_EQ(depth_code_name(make_depth_code(name)->id()), name);
}

}  // namespace
}  // namespace equistream
