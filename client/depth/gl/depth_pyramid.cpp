#include "depth_pyramid.h"

#include <algorithm>
#include <bit>

namespace equistream::gl {

namespace {

/// Powers of two, so that every texel of a level lies in one of the next.
int side_for(int texels) {
    const int blocks = (texels + DepthPyramid::block - 1) / DepthPyramid::block;
    return int(std::bit_ceil(unsigned(blocks)));
}

}  // namespace

DepthPyramid::DepthPyramid(std::span<const std::string> defines)
    : program_({{GL_COMPUTE_SHADER, "depth_pyramid.glsl"}}, defines) {}

void DepthPyramid::size_for(Size size, int layers) {
    size_ = {side_for(size.width), side_for(size.height)};
    level_count_ = std::bit_width(unsigned(std::max(size_.width, size_.height)));
    levels_ = make_layered_texture(size_, layers, GL_R32F, level_count_);
}

void DepthPyramid::build(const Texture& depth, int layers) const {
    Size size = size_;
    for (int level = 0; level < level_count_; ++level) {
        glBindTextureUnit(0, level == 0 ? depth.name() : levels_.name());
        glBindImageTexture(0, levels_.name(), level, GL_TRUE, 0, GL_WRITE_ONLY, GL_R32F);
        program_.set("finer_level", level - 1);
        program_.dispatch(size, layers);
        glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
        size = {std::max(1, size.width / 2), std::max(1, size.height / 2)};
    }
}

}  // namespace equistream::gl
