/// What was found of one source is not used for the next one.
#include "eye_renderer_stage.h"

#include <client/view/gl/eye_renderer.h>

#include <algorithm>
#include <string>

namespace equistream::test {
namespace {

using Frame = std::shared_ptr<const ReceivedFrame>;

class GlOtherSource : public GlEyeRenderer, public testing::WithParamInterface<std::string_view> {
protected:
    static std::array<EyePicture, 2> seen(gl::EyeRenderer& renderer, const Frame& frame,
                                          const gl::RefreshOptions& how) {
        gl::StageTimes times;
        gl::EyeTargets targets;
        const auto eyes = eyes_at({{0.02, 0.005, 0.01}, {1, 0, 0, 0}});
        renderer.show(frame, times);
        renderer.look(eyes, true, times);
        renderer.draw(how, targets, times);
        std::array<EyePicture, 2> pictures;
        for (std::size_t i = 0; i < 2; ++i)
            targets.download(int(i), pictures[i]);
        return pictures;
    }
    /// The first and then the second one, and the second one alone.
    static void expect_as_if_first(const Frame& first, const Frame& second, const std::string& passes) {
        const double radius_m = head_box_radius(second->main.info);
        gl::EyeRenderer after(nullptr, radius_m, passes, GetParam()), alone(nullptr, radius_m, passes, GetParam());
        const auto of_first = seen(after, first, {}), found = seen(after, second, {}),
                   expected = seen(alone, second, {});
        for (std::size_t i = 0; i < 2; ++i) {
            EXPECT_TRUE(std::ranges::equal(found[i].rgba.samples(), expected[i].rgba.samples()));
            EXPECT_TRUE(std::ranges::equal(found[i].origin.samples(), expected[i].origin.samples()));
            EXPECT_FALSE(std::ranges::equal(of_first[i].rgba.samples(), expected[i].rgba.samples()));
        }
    }
};

/// The same picture from nearer: nothing but its depth is another.
TEST_P(GlOtherSource, DepthIsFoundAnewOfTheNextOne) {
    const Frame frame = make_frame(0, flat, true);
    const auto nearer = std::make_shared<ReceivedFrame>(*frame);
    for (float& r : nearer->main.depth_m.samples())
        r *= 0.6f;
    expect_as_if_first(frame, nearer, "hidden,pushpull");
}

TEST_P(GlOtherSource, OfOneWithoutDepthNoneIsKnown) {
    const Frame frame = make_frame(0, flat, true);
    const auto without = std::make_shared<ReceivedFrame>(*frame);
    without->main.depth_m = {};
    expect_as_if_first(frame, without, "hidden,small,pushpull");
    gl::EyeRenderer renderer(nullptr, head_box_radius(frame->main.info), default_fill, GetParam());
    seen(renderer, frame, {});
    EXPECT_NE(renderer.depth().texture, 0u);
    seen(renderer, without, {});
    EXPECT_EQ(renderer.depth().texture, 0u);
}

/// A picture of another size says of no gap what it sees: neither by itself nor by what the hidden layer, which lies
/// all along the wall here, left in those of the mirror.
TEST_P(GlOtherSource, AnEarlierOneOfAnotherSizeFillsNothing) {
    const PerspectiveCamera smaller{200, 126, flat.fov_x_rad};
    const auto frame = std::make_shared<ReceivedFrame>(*make_frame(1, flat, true));
    frame->hidden->depth_m = render(wall_alone, red_and_smooth, flat, frame->hidden->info.camera_pose).depth_m;
    const double radius_m = head_box_radius(frame->main.info);
    const auto filled_by_earlier = [&](const Camera& before) {
        gl::EyeRenderer renderer(nullptr, radius_m, "hidden,earlier,pushpull", GetParam());
        const gl::RefreshOptions how{.mirrors = MirrorTreatment::gaps};
        seen(renderer, make_frame(0, before, true), how);
        std::int64_t count = 0;
        for (const EyePicture& picture : seen(renderer, frame, how))
            count += picture.count(PixelOrigin::earlier);
        return count;
    };
    EXPECT_GT(filled_by_earlier(flat), 0);
    EXPECT_EQ(filled_by_earlier(smaller), 0);
}

INSTANTIATE_TEST_SUITE_P(By, GlOtherSource, testing::Values("mesh", "mesh-plain"), [](const auto& test) {
    std::string name(test.param);
    std::erase(name, '-');
    return name;
});

}  // namespace
}  // namespace equistream::test
