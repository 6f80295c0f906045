#include "specular.h"

#include <equistream/text.h>

#include <client/reflections/mirror_kernels.h>

#include <cmath>
#include <string>
#include <vector>

namespace equistream::gl {

void SpecularTextures::size_for(Size size, bool has_mask) {
    has_mask_ = has_mask;
    if (!has_mask || size == size_)
        return;
    size_ = {};  // what fails half-way is begun anew
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

namespace {

std::vector<std::string> defines() {
    return {formatted("MAX_IMAGE_DISPLACEMENT %.9g", double(max_image_displacement)),
            formatted("MAX_IMAGE_STEPS %d", max_image_steps), formatted("MAX_IMAGE_TURNS %d", max_image_turns)};
}

}  // namespace

Mirrors::Mirrors() : program_("mirrors.glsl", defines()) {}

void Mirrors::rework(const SpecularSource& picture, std::span<const EyeView> eyes, const EyeDepth& depth,
                     const EyeTargets& targets, MirrorTreatment treatment) {
    const auto& [view, source, specular] = picture;
    if (!picture.tells() || depth.texture == 0 || treatment == MirrorTreatment::surface)
        return;
    blocks_.set(view, eyes, SpecularOptions{}.error_budget_px);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, source.grid());
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, blocks_.name());
    glBindTextureUnit(0, source.colour());
    glBindTextureUnit(1, source.depth());
    glBindTextureUnit(2, depth.texture);
    glBindTextureUnit(3, targets.origin());
    specular.bind();
    glBindImageTexture(0, targets.colour(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA8);
    glBindImageTexture(1, targets.origin(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R8UI);
    program_.set("inverse_depth_scale", depth.scale);
    program_.set("looks_for_images", int(treatment == MirrorTreatment::images));
    program_.dispatch(targets.size(), targets.eyes());
    finish_pictures();
}

}  // namespace equistream::gl
