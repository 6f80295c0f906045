#pragma once
/// Pixels that a first pass leaves to a second one, listed on the GPU: where lanes run both sides of every branch, a
/// rule that few pixels need would cost all of them.
#include <client/gpu/program.h>

#include <cstddef>

namespace equistream::gl {

class PixelList {
public:
    PixelList();

    /// For so many pixels, of up to 32,768 columns and rows and four layers. Storage grows and is kept.
    void size_for(std::size_t pixels);
    /// Empties the list, and binds it for shaders that include pixel_list.glsl.
    void start() const;
    /// Runs such a program, whose groups are of 256, once for each pixel that was listed before.
    void dispatch(const Program& program) const;

private:
    Program groups_;
    std::size_t pixels_ = 0;
    Buffer list_;
};

}  // namespace equistream::gl
