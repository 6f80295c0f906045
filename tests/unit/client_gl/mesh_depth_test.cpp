/// Engine `mesh` on the GPU shows what it shows on the CPU.
#include "engine_scenes.h"
#include "found_pictures.h"
#include "gl_fixture.h"

#include <reproject/gl/look_up.h>
#include <reproject/gl/mesh_depth.h>

#include <equistream_client/engine.h>

#include <array>

namespace equistream::test {
namespace {

const PerspectiveCamera eye_camera{240, 150, pi / 2};

class GlMeshDepth : public Gl {
protected:
    struct Seen {
        std::array<EyePicture, 2> pictures;
        std::array<FloatImage, 2> inverse_planar;
    };

    Seen see(const SourceView& view, std::span<const EyeView> eyes) {
        gl::SourceTextures textures;
        textures.upload(view);
        gl::EyeTargets targets;
        targets.size_for(eyes.front().camera, int(eyes.size()));
        mesh.forget_source();
        mesh.find(view, textures, eyes);
        surface.reproject(view, textures, eyes, mesh.depth(), targets);
        mesh.forget_gaps(targets);
        Seen seen;
        for (std::size_t i = 0; i < eyes.size(); ++i) {
            targets.download(int(i), seen.pictures[i]);
            seen.inverse_planar[i] = FloatImage(eye_camera.width, eye_camera.height, 1);
            gl::download(mesh.depth().texture, int(i), targets.size(), {GL_RED, GL_FLOAT, sizeof(float)},
                         seen.inverse_planar[i].samples().data(), sizeof(float) * std::size_t(eye_camera.width));
        }
        return seen;
    }

    gl::MeshDepth mesh;
    gl::LookUp surface{true};
};

TEST_F(GlMeshDepth, ShowsWhatTheCpuShows) {
    const SurfaceScene scene = furnished();
    const std::vector<Pose> poses = engine_eyes();
    const auto cpu = make_engine("mesh");
    for (const Camera& camera : engine_sources(720)) {
        SCOPED_TRACE(width_of(camera));
        const Rendered source = render(scene, smooth_colour, camera, Pose{{0, 0, 0}, yaw_pitch(0.7, 0.1)});
        const SourceView view = source.source(0.11);
        cpu->set_source(view);
        for (std::size_t i = 0; i + 1 < poses.size(); i += 2) {
            const std::array<EyeView, 2> eyes = {EyeView{eye_camera, poses[i], {}}, {eye_camera, poses[i + 1], {}}};
            const Seen seen = see(view, eyes);
            for (std::size_t k = 0; k < 2; ++k) {
                EyePicture expected;
                cpu->reproject(eyes[k], expected);
                const EyePicture& found = seen.pictures[k];
                EXPECT_GT(psnr_where_seen(expected, found), 50) << "eye " << i + k;
                // Of 36,000 pixels: those on edges, where rounding decides.
                EXPECT_LE(other_origins(expected, found), 36) << "eye " << i + k;
            }
        }
    }
}

}  // namespace
}  // namespace equistream::test
