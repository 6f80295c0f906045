#include "specular_textures.h"

#include <cmath>

namespace equistream::gl {

void SpecularTextures::size_for(Size size, bool has_mask) {
    has_mask_ = has_mask;
    if (!has_mask || size == size_)
        return;
    mask_ = make_texture(size, GL_R32F);
    virtual_depth_ = make_texture(size, GL_R32F);
    size_ = size;
}

void SpecularTextures::upload(const SourceView& source) {
    size_for({source.specular.width, source.specular.height}, source.specular.data != nullptr);
    if (!has_mask_)
        return;
    const auto put = [&](const Texture& texture, const ImageView<const float>& plane) {
        glPixelStorei(GL_UNPACK_ROW_LENGTH, GLint(plane.row_stride / plane.channels));
        glTextureSubImage2D(texture.name(), 0, 0, 0, size_.width, size_.height, GL_RED, GL_FLOAT, plane.data);
        glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
    };
    put(mask_, source.specular);
    const float unknown = std::nanf("");
    if (source.virtual_depth_m.data != nullptr)
        put(virtual_depth_, source.virtual_depth_m);
    else
        glClearTexImage(virtual_depth_.name(), 0, GL_RED, GL_FLOAT, &unknown);
}

void SpecularTextures::bind() const {
    glBindTextureUnit(6, mask_.name());
    glBindTextureUnit(7, virtual_depth_.name());
}

}  // namespace equistream::gl
