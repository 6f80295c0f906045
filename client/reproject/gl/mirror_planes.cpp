#include "mirror_planes.h"

#include <cmath>

namespace equistream::gl {

void MirrorPlanes::upload(const SourceView& source) {
    has_mask_ = source.specular.data != nullptr;
    if (!has_mask_)
        return;
    const Size size{source.specular.width, source.specular.height};
    if (!(size == size_)) {
        specular_ = make_texture(size, GL_R32F);
        virtual_depth_ = make_texture(size, GL_R32F);
        size_ = size;
    }
    const auto put = [&](const Texture& texture, const ImageView<const float>& plane) {
        glPixelStorei(GL_UNPACK_ROW_LENGTH, GLint(plane.row_stride / plane.channels));
        glTextureSubImage2D(texture.name(), 0, 0, 0, size.width, size.height, GL_RED, GL_FLOAT, plane.data);
        glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
    };
    put(specular_, source.specular);
    const float unknown = std::nanf("");
    if (source.virtual_depth_m.data != nullptr)
        put(virtual_depth_, source.virtual_depth_m);
    else
        glClearTexImage(virtual_depth_.name(), 0, GL_RED, GL_FLOAT, &unknown);
}

void MirrorPlanes::bind() const {
    glBindTextureUnit(6, specular_.name());
    glBindTextureUnit(7, virtual_depth_.name());
}

}  // namespace equistream::gl
