#pragma once
/// Targets of eyes whose depth others found: engines and fill passes are given it as they would leave it themselves.
#include <client/warp/eye_rays.h>
#include <client/warp/gl/eye_targets.h>

#include <limits>

namespace equistream::gl {

class TargetsWithDepth : public EyeTargets {
public:
    void size_for(const PerspectiveCamera& camera, int eyes) {
        if (size() == Size{camera.width, camera.height} && this->eyes() == eyes)
            return;
        EyeTargets::size_for(camera, eyes);
        depth_ = make_layered_texture(size(), eyes, GL_R32F);
    }
    /// As EyeView has it; kept as inverse planar depth, NaN where nothing is known.
    void upload_depth(int eye, const PerspectiveCamera& camera, const ImageView<const float>& depth_m) {
        const EyeRays rays(camera, {}, {});
        FloatImage inverse(depth_m.width, depth_m.height, 1);
        for (int y = 0; y < depth_m.height; ++y)
            for (int x = 0; x < depth_m.width; ++x) {
                const float r = *depth_m.pixel(x, y);
                *inverse.pixel(x, y) = r > 0 ? rays.length(x, y) / r : std::numeric_limits<float>::quiet_NaN();
            }
        glTextureSubImage3D(depth_.name(), 0, 0, 0, eye, depth_m.width, depth_m.height, 1, GL_RED, GL_FLOAT,
                            inverse.samples().data());
    }
    EyeDepth depth() const { return {depth_.name(), 1}; }

private:
    Texture depth_;
};

}  // namespace equistream::gl
