#include "eye_depth_finder.h"

#include <cassert>

namespace equistream::gl {

void EyeDepthFinder::bind(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes) {
    assert((source.depth() != 0 || !traits_.needs_depth) && !eyes.empty() && eyes.size() <= std::size_t(max_eyes));
    eye_blocks_.set(view, eyes, options_.error_budget_px);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, source.grid());
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, eye_blocks_.name());
    glBindTextureUnit(1, source.depth());
    lattice_.bind();
}

}  // namespace equistream::gl
