#include "eye_targets.h"

#include <equistream/bound.h>

#include <client/warp/engine.h>
#include <client/warp/eye_rays.h>

#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

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

namespace {

/// As std140 has it.
struct EyeBlock {
    glm::vec4 corner, right, down, eye, eye_own_axes;
    glm::mat4 source_from_eye;
    glm::vec4 view, agreement;
};

glm::vec4 padded(Vec3f v) {
    return {v.x, v.y, v.z, 0};
}

}  // namespace

EyeBlocks::EyeBlocks() : blocks_(make_buffer(max_eyes * sizeof(EyeBlock), GL_DYNAMIC_STORAGE_BIT)) {}

void EyeBlocks::set(const SourceView& source, std::span<const EyeView> eyes, double error_budget_px) {
    std::array<Pose, max_eyes> sources;
    sources.fill(source.pose);
    set(std::span(sources).first(eyes.size()), source.box_radius_m, eyes, error_budget_px);
}

void EyeBlocks::set(std::span<const Pose> sources, double box_radius_m, std::span<const EyeView> eyes,
                    double error_budget_px) {
    assert(eyes.size() <= std::size_t(max_eyes) && sources.size() == eyes.size());
    std::array<EyeBlock, max_eyes> blocks;
    for (std::size_t i = 0; i < eyes.size(); ++i) {
        const EyeRays rays(eyes[i].camera, eyes[i].pose, sources[i]);
        const bool moved = !same_position(sources[i], eyes[i].pose);
        const double tolerance_rad = error_budget_rad(eyes[i].camera.focal_px(), error_budget_px);
        blocks[i] = {padded(rays.corner()),
                     padded(rays.right()),
                     padded(rays.down()),
                     padded(rays.eye()),
                     padded(rays.eye_own_axes()),
                     glm::mat4(rays.source_from_eye()),
                     {rays.focal_px(), rays.centre_x(), rays.centre_y(), moved ? 1.0f : 0.0f},
                     {std::max(float(box_radius_m), rays.distance_m()), std::sin(tolerance_rad), 0, 0}};
    }
    glNamedBufferSubData(blocks_.name(), 0, GLsizeiptr(eyes.size() * sizeof(EyeBlock)), blocks.data());
}

EyeDepthLayers::EyeDepthLayers() : forget_gaps_({{GL_COMPUTE_SHADER, "forget_gaps.glsl"}}) {}

bool EyeDepthLayers::size_for(Size size, int eyes) {
    if (size == size_ && eyes == eyes_)
        return true;
    depth_ = make_layered_texture(size, eyes, GL_R32F);
    size_ = size;
    eyes_ = eyes;
    return false;
}

void EyeDepthLayers::bind(GLuint unit) const {
    glBindImageTexture(unit, depth_.name(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R32F);
}

void EyeDepthLayers::forget_gaps(const EyeTargets& targets) const {
    assert(targets.size() == size_ && targets.eyes() == eyes_);
    glBindTextureUnit(3, targets.origin());
    bind(0);
    forget_gaps_.dispatch(size_, eyes_);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_FRAMEBUFFER_BARRIER_BIT);
}

}  // namespace equistream::gl
