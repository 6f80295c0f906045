/// The fast map against the plain one, on every instruction set. Both go through the same steps, but not through the
/// same roundings: which value of a pixel is right is known only as well as its risks are.
#include <tests/unit/client/reliability_scene.h>
#include <tests/unit/client/simd_targets.h>

#include <tests/support/references/plain_engines.h>

#include <gtest/gtest.h>

#include <random>

namespace equistream::test {
namespace {

/// Inverse depth differs by the few roundings of its square root and quotient and by the 3e-7 of the fast root: less
/// than 16 units of rounding (2^-24). Rays into the source differ by fast_atan2's 4e-7 rad and as much again.
constexpr double depth_rounding = 0x1p-20, ray_rounding_rad = 1e-6;
/// Differences of neighbouring depths make more of that, thresholds may fall to either side of it. So it is tried.
constexpr int draws = 16;
/// A risk is a logarithm below 16, of which four roundings are lost; then a sum of 16 products each loses one of its
/// terms' at every step.
constexpr float log_rounding = 0x1p-18f, sum_rounding = 0x1p-20f;

/// The values between which a pixel of the map may lie.
struct ValueRange {
    float least = 255, most = 0;

    void add(RiskGroup group, const float* risks, const VisibleLoss& loss) {
        std::array<float, risk_count> above, below;
        for (std::size_t k = 0; k < risk_count; ++k) {
            const float rounding = log_rounding + sum_rounding * risks[k];
            above[k] = risks[k] + rounding;
            below[k] = std::max(0.0f, risks[k] - rounding);
        }
        // More of a risk never makes a pixel more trustworthy.
        const auto kept = [&](float texture) {
            const float lost = loss_at(loss, texture);
            return 255 * (1 - lost) * (1 - 0.3f * lost);
        };
        const auto [min_kept, max_kept] =
            std::minmax({kept(above[std::size_t(Risk::texture)]), kept(below[std::size_t(Risk::texture)])});
        least = std::min(least, std::floor(min_kept * plain::reliability_of(group, above) + 0.499f));
        most = std::max(most, std::floor(max_kept * plain::reliability_of(group, below) + 0.501f));
    }
};

/// One picture to be judged.
struct Judged {
    const SourceView& source;
    const EyeView& eye;
    const EyePicture& picture;
    const ReliabilityOptions& options;
};

FloatImage rounded_otherwise(ImageView<const float> depth_m, std::mt19937& random) {
    FloatImage other(depth_m.width, depth_m.height, 1);
    for (int y = 0; y < depth_m.height; ++y)
        for (int x = 0; x < depth_m.width; ++x)
            other.pixel(x, y)[0] =
                float(double(depth_m.pixel(x, y)[0]) * (1 + (random() % 2 == 0 ? depth_rounding : -depth_rounding)));
    return other;
}

std::vector<ValueRange> possible_values(const Judged& judged) {
    std::vector<ValueRange> ranges(judged.picture.origin.samples().size());
    std::mt19937 random(3);
    for (int draw = 0; draw <= draws; ++draw) {
        EyeView eye = judged.eye;
        FloatImage depth_m;
        const ImageView<const float> known = eye.depth_m.data != nullptr ? eye.depth_m : judged.picture.depth_m.view();
        if (draw > 0) {
            if (known.data != nullptr) {
                depth_m = rounded_otherwise(known, random);
                eye.depth_m = depth_m.view();
            }
            const double turn_rad = draw % 2 == 0 ? ray_rounding_rad : -ray_rounding_rad;
            const dvec3 axis = draw % 4 < 2 ? dvec3(0, 1, 0) : dvec3(1, 0, 0);
            eye.pose.orientation = glm::angleAxis(turn_rad, axis) * eye.pose.orientation;
        }
        const FloatImage risks = plain::reliability_risks(judged.source, eye, judged.picture, judged.options);
        const ByteImage groups = plain::reliability_groups(judged.source, eye, judged.picture, judged.options);
        for (std::size_t i = 0; i < ranges.size(); ++i) {
            const std::uint8_t group = groups.samples()[i];
            if (group == no_risk_group)
                ranges[i] = {0, 0};
            else
                ranges[i].add(RiskGroup(group), &risks.samples()[i * risk_count],
                              judged.options.visible_loss.value_or(VisibleLoss()));
        }
    }
    return ranges;
}

/// On every instruction set each pixel has a value that it may have. Hardly any has a choice: sums are known to some
/// 3e-4, and of those with entries of 1/16 one in a hundred lies so near the end of one.
void expect_possible_values(const SourceView& source, const EyeView& eye, EyePicture& picture,
                            const ReliabilityOptions& options = {}) {
    const std::vector<ValueRange> ranges = possible_values({source, eye, picture, options});
    const auto open = std::ranges::count_if(ranges, [](const ValueRange& r) { return r.least < r.most; });
    EXPECT_LE(double(open), 0.01 * double(ranges.size()));
    const auto expect_in_range = [&](const char* name) {
        for (std::size_t i = 0; i < ranges.size(); ++i) {
            const float value = picture.reliability.samples()[i];
            // What reliability_of gives is that of a byte again, within a rounding.
            ASSERT_TRUE(value > ranges[i].least - 0.01f && value < ranges[i].most + 0.01f)
                << name << ", pixel " << i << ": " << value << ", not from " << ranges[i].least << " to "
                << ranges[i].most;
        }
    };
    plain::estimate_reliability(source, eye, picture, options);
    expect_in_range("plain");
    for (const std::int64_t target : targets_here()) {
        const OnlyTarget only(target);
        estimate_reliability(source, eye, picture, options);
        expect_in_range(hwy::TargetName(target));
    }
}

/// So that no difference between neighbours is like another.
void add_noise(EyePicture& picture) {
    std::mt19937 random(7);
    for (std::uint8_t& sample : picture.rgba.samples())
        sample = std::uint8_t(std::clamp<int>(sample + int(random() % 41) - 20, 0, 255));
}

TEST(ReliabilityMap, EveryInstructionSetMakesThePlainMap) {
    for (const char* fill : {"none", "pushpull", "spread"})
        for (const char* method : {"surface", "sphere", "splat"}) {
            SCOPED_TRACE(std::string(method) + " " + fill);
            Played played(ball_and_wall, smooth_colour, moved, method, fill);
            add_noise(played.picture);
            expect_possible_values(played.view(), played.eye, played.picture, {.depth_tolerance_w = 0.01});
            expect_possible_values(played.view(), played.eye, played.picture,
                                   {.visible_loss = VisibleLoss{{1, 5, 9, 30, 4, 4, 60, 255}}});
        }
    Played still(ball_and_wall, smooth_colour, Pose{}, "surface", "none");
    add_noise(still.picture);
    expect_possible_values(still.view(), still.eye, still.picture);
}

TEST(ReliabilityMap, EveryInstructionSetFindsMirrors) {
    Played played(ball_and_wall, smooth_colour, moved, "surface", "pushpull");
    FloatImage specular(640, 320, 1);
    for (int y = 0; y < 320; ++y)
        for (int x = 0; x < 640; ++x)
            specular.pixel(x, y)[0] = (x / 7 + y / 5) % 2 == 0 ? 1.0f : 0.0f;
    SourceView source = played.view();
    source.specular = specular.view();
    add_noise(played.picture);
    expect_possible_values(source, played.eye, played.picture);
}

/// Every kind of origin side by side, widths that leave a rest of each vector's lanes, and more rows
/// than a band has. (A picture 34 wide is just wide enough for vectors, one 20 or 1 wide is not.)
TEST(ReliabilityMap, EveryInstructionSetTakesAnyOriginAndSize) {
    const Rendered source = render(ball_and_wall, smooth_colour, EquirectCamera{64, 32, {}}, Pose{});
    for (const auto& [width, height] : {std::pair{34, 7}, {61, 41}, {97, 70}, {20, 9}, {1, 3}}) {
        SCOPED_TRACE(std::to_string(width) + " x " + std::to_string(height));
        const PerspectiveCamera camera{width, height, 1.2};
        EyePicture picture;
        picture.reset(camera);
        FloatImage depth_m(width, height, 1);
        std::mt19937 random(static_cast<unsigned>(width));
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                for (int c = 0; c < 4; ++c)
                    picture.rgba.pixel(x, y)[c] = std::uint8_t(random() % 256);
                picture.origin.pixel(x, y)[0] =
                    std::uint8_t(random() % 3 == 0 ? random() % unsigned(pixel_origin_count) : 1);
                depth_m.pixel(x, y)[0] = random() % 9 == 0 ? float(infinity) : 1 + float(random() % 1000) / 500;
            }
        expect_possible_values(source.source(0.063), {camera, moved, depth_m.view()}, picture);
    }
}

}  // namespace
}  // namespace equistream::test
