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
#include <utility>

namespace equistream::gl {

void EyeTargets::size_for(const PerspectiveCamera& camera, int eyes) {
    assert(eyes > 0 && eyes <= max_eyes);
    const Size size{camera.width, camera.height};
    if (size == size_ && eyes == eyes_)
        return;
    Texture colour = make_layered_texture(size, eyes, GL_RGBA8), origin = make_layered_texture(size, eyes, GL_R8UI);
    framebuffer_ = make_framebuffer(std::array{colour.name(), origin.name()}, 0);
    colour_ = std::move(colour);
    origin_ = std::move(origin);
    size_ = size;
    eyes_ = eyes;
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
        blocks[i] = {glm::vec4(rays.corner(), 0),
                     glm::vec4(rays.right(), 0),
                     glm::vec4(rays.down(), 0),
                     glm::vec4(rays.eye(), 0),
                     glm::vec4(rays.eye_own_axes(), 0),
                     glm::mat4(rays.source_from_eye()),
                     {rays.focal_px(), rays.centre_x(), rays.centre_y(), moved ? 1.0f : 0.0f},
                     {std::max(float(box_radius_m), rays.distance_m()), std::sin(tolerance_rad), 0, 0}};
    }
    glNamedBufferSubData(blocks_.name(), 0, GLsizeiptr(eyes.size() * sizeof(EyeBlock)), blocks.data());
}

}  // namespace equistream::gl
