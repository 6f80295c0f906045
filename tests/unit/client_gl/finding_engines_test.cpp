/// Engines `splat` and `gather` on the GPU show what their plain references show.
#include "engine_scenes.h"
#include "found_pictures.h"
#include "gl_fixture.h"

#include <reproject/gl/gather_depth.h>
#include <reproject/gl/look_up.h>
#include <reproject/gl/splat_depth.h>

#include <equistream_client/engine.h>

#include <array>

namespace equistream::test {
namespace {

const PerspectiveCamera eye_camera{240, 150, pi / 2};

struct Splat {
    static constexpr const char* name = "splat";
    static constexpr double least_psnr_db = 55;
    static constexpr int most_others = 5;  ///< of 36,000 pixels
    gl::SplatDepth depth;
    void find(const SourceView& view, const gl::SourceTextures& textures, std::span<const EyeView> eyes) {
        depth.find(view, textures, eyes);
    }
};

struct Gather {
    static constexpr const char* name = "gather";
    static constexpr double least_psnr_db = 49;  ///< fixed points and steps along a ray part at silhouettes
    static constexpr int most_others = 50;
    gl::GatherDepth depth;
    void find(const SourceView& view, const gl::SourceTextures& textures, std::span<const EyeView> eyes) {
        depth.forget_source();
        depth.find(view, textures, eyes);
    }
};

template <typename Engine>
class GlFindingEngines : public Gl {
protected:
    std::array<EyePicture, 2> see(const SourceView& view, std::span<const EyeView> eyes) {
        gl::SourceTextures textures;
        textures.upload(view);
        gl::EyeTargets targets;
        targets.size_for(eyes.front().camera, int(eyes.size()));
        engine.find(view, textures, eyes);
        surface.reproject(view, textures, eyes, engine.depth.depth(), targets);
        std::array<EyePicture, 2> pictures;
        for (std::size_t i = 0; i < eyes.size(); ++i)
            targets.download(int(i), pictures[i]);
        return pictures;
    }

    Engine engine;
    gl::LookUp surface{true};
};

using Engines = testing::Types<Splat, Gather>;
TYPED_TEST_SUITE(GlFindingEngines, Engines);

TYPED_TEST(GlFindingEngines, ShowWhatTheirReferencesShow) {
    const SurfaceScene scene = furnished();
    const std::vector<Pose> poses = engine_eyes();
    const auto plain = make_engine(TypeParam::name, {.reference = true});
    for (const Camera& camera : engine_sources(720)) {
        SCOPED_TRACE(width_of(camera));
        const Rendered source = render(scene, smooth_colour, camera, Pose{{0, 0, 0}, yaw_pitch(0.7, 0.1)});
        const SourceView view = source.source(0.11);
        plain->set_source(view);
        for (std::size_t i = 0; i + 1 < poses.size(); i += 2) {
            const std::array<EyeView, 2> eyes = {EyeView{eye_camera, poses[i], {}}, {eye_camera, poses[i + 1], {}}};
            const std::array<EyePicture, 2> seen = this->see(view, eyes);
            for (std::size_t k = 0; k < 2; ++k) {
                EyePicture expected;
                plain->reproject(eyes[k], expected);
                EXPECT_GT(psnr_where_seen(expected, seen[k]), TypeParam::least_psnr_db) << "eye " << i + k;
                EXPECT_LE(other_origins(expected, seen[k]), TypeParam::most_others) << "eye " << i + k;
            }
        }
    }
}

}  // namespace
}  // namespace equistream::test
