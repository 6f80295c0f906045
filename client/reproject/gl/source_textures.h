#pragma once
/// A source picture on the GPU. The context it was made in is current in every call.
#include <gl/program.h>

#include <equistream_client/view.h>

#include <array>

namespace equistream::gl {

class SourceTextures {
public:
    SourceTextures();

    /// Uploads all planes of the view that it has (specular and virtual depth stay behind); the view's pixels are read
    /// before this returns. Storage is kept as long as sizes stay.
    void upload(const SourceView& source);

    Size size() const { return size_; }
    GLuint colour() const { return colour_.name(); }
    GLuint depth() const { return depth_.name(); }  ///< 0: the view had none
    GLuint grid() const { return grid_.name(); }    ///< the uniform block of source_grid.glsl

private:
    void upload_rgb(const ImageView<const std::uint8_t>& rgb);
    void upload_yuv(const YuvView& yuv);

    Program yuv_to_rgb_;
    Size size_;
    Texture colour_, depth_;
    std::array<Texture, 3> planes_;
    Buffer grid_;
};

}  // namespace equistream::gl
