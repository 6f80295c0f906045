#include "eye_targets.h"

#include <client/warp/eye_rays.h>

#include <array>
#include <cassert>

namespace equistream::gl {

void EyeTargets::size_for(const PerspectiveCamera& camera, int eyes) {
    assert(eyes > 0 && eyes <= max_eyes);
    const Size size{camera.width, camera.height};
    if (size == size_ && eyes == eyes_)
        return;
    size_ = size;
    eyes_ = eyes;
    colour_ = make_layered_texture(size, eyes, GL_RGBA8);
    origin_ = make_layered_texture(size, eyes, GL_R8UI);
    depth_ = make_layered_texture(size, eyes, GL_R32F);
    GLuint name = 0;
    glCreateFramebuffers(1, &name);
    framebuffer_ = Framebuffer(name);
    glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, colour_.name(), 0);
    glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT1, origin_.name(), 0);
    constexpr std::array<GLenum, 2> both = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    glNamedFramebufferDrawBuffers(name, both.size(), both.data());
    require_complete(framebuffer_);
}

void EyeTargets::upload_depth(int eye, const PerspectiveCamera& camera, const ImageView<const float>& depth_m) {
    assert(depth_m.width == size_.width && depth_m.height == size_.height && depth_m.channels == 1);
    const FloatImage inverse = EyeRays(camera, {}, {}).inverse_planar_depth(depth_m);
    glTextureSubImage3D(depth_.name(), 0, 0, 0, eye, size_.width, size_.height, 1, GL_RED, GL_FLOAT,
                        inverse.samples().data());
}

void EyeTargets::download(int eye, EyePicture& picture) const {
    picture.rgba = ByteImage(size_.width, size_.height, 4);
    picture.origin = ByteImage(size_.width, size_.height, 1);
    picture.reliability = {};
    picture.depth_m = {};
    const auto get = [&](const Texture& texture, const gl::PixelLayout& layout, ByteImage& to) {
        gl::download(texture.name(), eye, size_, layout, to.samples().data(), layout.bytes * std::size_t(size_.width));
    };
    get(colour_, {GL_RGBA, GL_UNSIGNED_BYTE, 4}, picture.rgba);
    get(origin_, {GL_RED_INTEGER, GL_UNSIGNED_BYTE, 1}, picture.origin);
}

}  // namespace equistream::gl
