#pragma once
/// What eyes of one size see, on the GPU: a layer for each.
#include <equistream/bound.h>

#include <client/gpu/program.h>
#include <client/warp/view.h>

#include <span>

namespace equistream::gl {

inline constexpr int max_eyes = 2;

/// Inverse planar depth of eyes: layers of a texture, whose samples times `scale` are 1 / m; 0 for a miss.
struct EyeDepth {
    GLuint texture = 0;
    float scale = 1;
    GLenum format = GL_RED;  ///< in which its samples come to memory: GL_DEPTH_COMPONENT of a depth buffer
};

class EyeTargets {
public:
    /// Storage is kept as long as the size stays.
    void size_for(const PerspectiveCamera& camera, int eyes);
    /// Waits for the GPU. Colours and origins; the rest is emptied.
    void download(int eye, EyePicture& picture) const;

    Size size() const { return size_; }
    int eyes() const { return eyes_; }
    GLuint colour() const { return colour_.name(); }
    GLuint origin() const { return origin_.name(); }
    GLuint framebuffer() const { return framebuffer_.name(); }  ///< draws to colour and origin, all layers

private:
    Size size_;
    int eyes_ = 0;
    Texture colour_, origin_;
    Framebuffer framebuffer_;
};

// What eye_rays.glsl knows of the eyes: how they look at one source.

class EyeBlocks {
public:
    EyeBlocks();

    /// Of up to max_eyes eyes; `error_budget_px` as in EngineOptions.
    void set(const SourceView& source, std::span<const EyeView> eyes, double error_budget_px = default_error_budget_px);
    /// Each eye and the source that it looks at, all with one head box.
    void set(std::span<const Pose> sources, double box_radius_m, std::span<const EyeView> eyes,
             double error_budget_px = default_error_budget_px);
    GLuint name() const { return blocks_.name(); }

private:
    Buffer blocks_;
};

}  // namespace equistream::gl
