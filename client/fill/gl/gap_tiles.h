#pragma once
/// Where the eyes' pictures have gaps: squares of 8x8 pixels, found on the GPU and listed there, so that passes go
/// through those alone without the CPU's knowing how many there are.
#include <client/warp/gl/eye_targets.h>

#include <client/gpu/program.h>

namespace equistream::gl {

class GapTiles {
public:
    /// Which tiles a pass goes through.
    enum class List { with_gaps_or_beside, with_gaps };

    /// Of tiles that have what: gaps, or pixels that are not the source's, the same in what follows.
    enum class Of { gaps, not_source };

    explicit GapTiles(Of of = Of::gaps);

    /// Looks through all origins of the targets. Storage is kept as long as their size stays.
    void find(const EyeTargets& targets);

    /// For shaders that include gap_tiles.glsl: binds storage 0 and 1.
    void bind() const;
    /// Runs such a program, whose groups are of 256, for each cell of the listed tiles, which are 1 << `shift` cells
    /// wide.
    void dispatch(const Program& program, List list, int shift) const;
    /// Tiles of one eye.
    Size grid() const { return grid_; }

private:
    void size_for(const EyeTargets& targets);

    Program find_, list_;
    Size grid_;
    int eyes_ = 0;
    Buffer states_, lists_;
};

}  // namespace equistream::gl
