#include "splat_depth.h"

namespace equistream::gl {

SplatDepth::SplatDepth(const EngineOptions& options)
    : EyeDepthFinder(options), splat_({{GL_COMPUTE_SHADER, "splat.glsl"}}),
      end_({{GL_COMPUTE_SHADER, "splat_end.glsl"}}) {}

void SplatDepth::find(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes) {
    const Size size{eyes.front().camera.width, eyes.front().camera.height};
    const auto count = int(eyes.size());
    if (!layers_.size_for(size, count)) {
        nearest_ = make_layered_texture(size, count, GL_R32UI);
        const GLuint nothing = 0;
        glClearTexImage(nearest_.name(), 0, GL_RED_INTEGER, GL_UNSIGNED_INT, &nothing);
    }
    lattice_.set(view.camera);
    bind(view, source, eyes);
    glBindImageTexture(0, nearest_.name(), 0, GL_TRUE, 0, GL_READ_WRITE, GL_R32UI);
    splat_.dispatch(lattice_.size(), count);
    glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    layers_.bind(1);
    end_.dispatch(size, count);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT);
}

}  // namespace equistream::gl
