#include "splat_depth.h"

#include <cassert>

namespace equistream::gl {

SplatDepth::SplatDepth(const EngineOptions& options)
    : options_(options), splat_({{GL_COMPUTE_SHADER, "splat.glsl"}}), end_({{GL_COMPUTE_SHADER, "splat_end.glsl"}}) {}

void SplatDepth::find(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes) {
    assert(source.depth() != 0 && !eyes.empty() && eyes.size() <= std::size_t(most_eyes));
    const Size size{eyes.front().camera.width, eyes.front().camera.height};
    const auto count = int(eyes.size());
    if (!layers_.size_for(size, count)) {
        nearest_ = make_layered_texture(size, count, GL_R32UI);
        const GLuint nothing = 0;
        glClearTexImage(nearest_.name(), 0, GL_RED_INTEGER, GL_UNSIGNED_INT, &nothing);
    }
    lattice_.set(view.camera);
    eye_blocks_.set(view, eyes, options_.error_budget_px);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, source.grid());
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, eye_blocks_.name());
    glBindTextureUnit(1, source.depth());
    lattice_.bind();
    glBindImageTexture(0, nearest_.name(), 0, GL_TRUE, 0, GL_READ_WRITE, GL_R32UI);
    splat_.dispatch(lattice_.size(), count);
    glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    layers_.bind(1);
    end_.dispatch(size, count);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT);
}

}  // namespace equistream::gl
