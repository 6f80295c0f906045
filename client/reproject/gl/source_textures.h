#pragma once
/// A source picture on the GPU. The context it was made in is current in every call.
#include <gl/program.h>

#include <equistream_client/view.h>

#include <array>

namespace equistream::gl {

class SourceTextures {
public:
    SourceTextures();

    /// What directions of the source's samples are: for depth that a pass finds, where no picture is needed.
    void describe(const Camera& camera);
    /// Makes the depth of all samples unknown.
    void forget_depth();
    /// Uploads colour, and depth where the view has some (specular and virtual depth stay behind); the view's pixels
    /// are read before this returns. Storage is kept as long as sizes stay.
    void upload(const SourceView& source);

    Size size() const { return size_; }
    GLuint colour() const { return colour_.name(); }
    GLuint depth() const { return has_depth_ ? depth_.name() : 0; }  ///< 0: the view had none
    GLuint grid() const { return grid_.name(); }                     ///< the uniform block of source_grid.glsl
    /// The same texture for a pass that finds the depth here; where the view had none, NaN before that.
    GLuint depth_to_write();
    /// Colour for a pass that makes the picture here, of the camera that was described.
    GLuint colour_to_write();

private:
    void upload_rgb(const ImageView<const std::uint8_t>& rgb);
    void upload_yuv(const YuvView& yuv);
    void make_depth();

    Program yuv_to_rgb_;
    Size size_;
    Texture colour_, depth_;
    bool has_depth_ = false;  ///< what depth_ holds is of this view
    std::array<Texture, 3> planes_;
    Buffer grid_;
};

}  // namespace equistream::gl
