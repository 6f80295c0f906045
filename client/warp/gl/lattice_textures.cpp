#include "lattice_textures.h"

#include <client/warp/source_lattice.h>

#include <client/warp/engine.h>

#include <algorithm>
#include <vector>

namespace equistream::gl {

bool LatticeTextures::set(const Camera& camera) {
    if (camera_ && same_camera(camera, *camera_))
        return true;
    const LatticeAngles angles(camera);
    const std::size_t width = std::max(angles.column_a.size(), angles.row_a.size());
    angles_ = make_texture({int(width), 2}, GL_RG32F);
    const auto upload = [&](int row, const std::vector<float>& a, const std::vector<float>& b) {
        std::vector<float> both(2 * a.size());
        for (std::size_t i = 0; i < a.size(); ++i) {
            both[2 * i] = a[i];
            both[2 * i + 1] = b.empty() ? 0 : b[i];
        }
        glTextureSubImage2D(angles_.name(), 0, 0, row, GLsizei(a.size()), 1, GL_RG, GL_FLOAT, both.data());
    };
    upload(0, angles.column_a, angles.column_b);
    upload(1, angles.row_a, angles.row_b);
    camera_ = camera;
    size_ = {width_of(camera), height_of(camera)};
    return false;
}

void LatticeTextures::bind() const {
    glBindTextureUnit(5, angles_.name());
}

}  // namespace equistream::gl
