#pragma once
/// What eyes of one size see, on the GPU: a layer for each.
#include <client/gpu/program.h>

#include <client/warp/view.h>

namespace equistream::gl {

inline constexpr int max_eyes = 2;

/// Inverse planar depth of eyes: layers of a texture, whose samples times `scale` are 1 / m; 0 for a miss.
struct EyeDepth {
    GLuint texture = 0;
    float scale = 1;
};

class EyeTargets {
public:
    /// Storage is kept as long as the size stays.
    void size_for(const PerspectiveCamera& camera, int eyes);
    /// The depth of an eye that others found, as EyeView has it; kept as inverse planar depth, NaN where nothing is
    /// known.
    void upload_depth(int eye, const PerspectiveCamera& camera, const ImageView<const float>& depth_m);
    /// Waits for the GPU. Colours and origins; the rest is emptied.
    void download(int eye, EyePicture& picture) const;

    Size size() const { return size_; }
    int eyes() const { return eyes_; }
    GLuint colour() const { return colour_.name(); }
    GLuint origin() const { return origin_.name(); }
    GLuint framebuffer() const { return framebuffer_.name(); }  ///< draws to colour and origin, all layers
    EyeDepth depth() const { return {depth_.name(), 1}; }

private:
    Size size_;
    int eyes_ = 0;
    Texture colour_, origin_, depth_;
    Framebuffer framebuffer_;
};

}  // namespace equistream::gl
