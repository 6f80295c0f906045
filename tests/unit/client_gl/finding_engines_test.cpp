/// Engines `splat` and `gather` on the GPU show what their plain references show.
#include "engine_scenes.h"
#include "found_pictures.h"
#include "gl_fixture.h"

#include <reproject/gl/eye_depth_finder.h>
#include <reproject/gl/look_up.h>

#include <equistream_client/engine.h>

#include <array>
#include <ostream>
#include <string>

namespace equistream::test {
namespace {

/// Small: the plain reference of gather walks every ray in quarters of the source's pixels.
const PerspectiveCamera eye_camera{120, 75, pi / 2};
constexpr int source_width = 360;

/// Within which an engine is its plain reference, of 9,000 pixels.
struct Expected {
    const char* engine;
    double least_psnr_db;
    int most_others;

    friend std::ostream& operator<<(std::ostream& out, const Expected& expected) { return out << expected.engine; }
};

class GlFindingEngines : public Gl, public testing::WithParamInterface<Expected> {};

/// Fixed points and steps along a ray part at silhouettes, of which smaller pictures have more for their size.
INSTANTIATE_TEST_SUITE_P(Client, GlFindingEngines,
                         testing::Values(Expected{"splat", 55, 1}, Expected{"gather", 46, 25}),
                         [](const auto& test) { return std::string(test.param.engine); });

std::array<EyePicture, 2> seen_by(gl::EyeDepthFinder& finder, const SourceView& view, std::span<const EyeView> eyes) {
    gl::SourceTextures textures;
    textures.upload(view);
    gl::EyeTargets targets;
    targets.size_for(eyes.front().camera, int(eyes.size()));
    gl::LookUp surface{true};
    finder.forget_source();
    finder.find(view, textures, eyes);
    surface.reproject(view, textures, eyes, finder.depth(), targets);
    std::array<EyePicture, 2> pictures;
    for (std::size_t i = 0; i < eyes.size(); ++i)
        targets.download(int(i), pictures[i]);
    return pictures;
}

TEST_P(GlFindingEngines, ShowWhatTheirReferencesShow) {
    const auto [engine, least_psnr_db, most_others] = GetParam();
    const auto finder = gl::make_depth_finder(engine);
    const SurfaceScene scene = furnished();
    const std::vector<Pose> poses = engine_eyes();
    const auto plain = make_engine(engine, {.reference = true});
    for (const Camera& camera : engine_sources(source_width)) {
        SCOPED_TRACE(width_of(camera));
        const Rendered source = render(scene, smooth_colour, camera, Pose{{0, 0, 0}, yaw_pitch(0.7, 0.1)});
        const SourceView view = source.source(0.11);
        plain->set_source(view);
        for (std::size_t i = 0; i + 1 < poses.size(); i += 2) {
            const std::array<EyeView, 2> eyes = {EyeView{eye_camera, poses[i], {}}, {eye_camera, poses[i + 1], {}}};
            const std::array<EyePicture, 2> seen = seen_by(*finder, view, eyes);
            for (std::size_t k = 0; k < 2; ++k) {
                EyePicture expected;
                plain->reproject(eyes[k], expected);
                EXPECT_GT(psnr_where_seen(expected, seen[k]), least_psnr_db) << "eye " << i + k;
                EXPECT_LE(other_origins(expected, seen[k]), most_others) << "eye " << i + k;
            }
        }
    }
}

}  // namespace
}  // namespace equistream::test
