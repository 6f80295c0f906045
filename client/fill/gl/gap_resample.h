#pragma once
/// Gaps of the eyes' pictures on the GPU: found, and coloured from other pictures, patches and mirrors.
#include <client/fill/fill.h>
#include <client/gpu/program.h>
#include <client/reflections/gl/specular.h>
#include <client/warp/gl/eye_targets.h>
#include <client/warp/gl/source_textures.h>

#include <cstdint>
#include <span>
#include <vector>

namespace equistream::gl {

// Where the eyes' pictures have gaps: squares of 8x8 pixels, found on the GPU and listed there, so that passes go
// through those alone without the CPU's knowing how many there are.

class GapTiles {
public:
    /// Which tiles a pass goes through.
    enum class List { with_gaps_or_beside, with_gaps };

    /// Of tiles that have what: gaps, or pixels that are not the source's, the same in what follows.
    enum class Of { gaps, not_source };

    explicit GapTiles(Of of = Of::gaps);
    /// Of those that a program finds, as find_gap_tiles.glsl does; find() runs it as it is bound and set.
    explicit GapTiles(Program find);

    /// Looks through all origins of the targets. Storage is kept as long as their size stays.
    void find(const EyeTargets& targets);
    const Program& finder() const { return find_; }

    /// For shaders that include gap_tiles.glsl: binds storage 0 and 1.
    void bind() const;
    /// Runs such a program, whose groups are of 256, for each cell of the listed tiles, which are 1 << `shift` cells
    /// wide.
    void dispatch(const Program& program, List list, int shift) const;
    /// Draws points by the program in use: some where tiles are listed, else none.
    void draw_points(List list) const;
    /// Tiles of one eye.
    Size grid() const { return grid_; }

private:
    void size_for(const EyeTargets& targets);

    Program find_, list_;
    Size grid_;
    int eyes_ = 0;
    Buffer states_, lists_;
};

// Fill passes `hidden`, `earlier` and `small` (fill.h) on the GPU, for all eyes at once: gap pixels take what
// they see from another picture, by the eyes' depth: their own, or what fill_pass.h finds. What
// mirrors and glass show is not on them: such a pixel is coloured only where the picture shows the same in them from
// its own place, within the budget.

/// The eyes whose gaps a fill pass fills. What comes after needs no barrier of its own, as in Resample.
struct GapTargets {
    std::span<const EyeView> eyes;  ///< their depth_m is not read
    const EyeDepth& depth;
    /// Of the targets as they are, or as they were before some of their gaps were filled.
    const GapTiles& gaps;
    const EyeTargets& targets;
    /// How far behind the surface that a gap pixel sees its image in a mirror lies (GapMirrors), a layer for each eye;
    /// 0: mirrors are looked up like any surface.
    GLuint image_behind = 0;
    /// What the spheres around an earlier window and around today's show of what gap pixels see (SeenLight), a layer
    /// for each eye; 0: nobody asks whether light has changed.
    GLuint light_then = 0, light_now = 0;
};

/// The picture to look up in: what it is of, and its pixels, which are those of `view`.
struct OtherPicture {
    const SourceView& view;
    const SourceTextures& textures;
    PixelOrigin mark = PixelOrigin::gap;
};

class GapResample {
public:
    GapResample();

    /// By the picture's depth and the eyes'; where either has none by direction alone, of a small view; others fill
    /// nothing then.
    void fill(const OtherPicture& from, const GapTargets& to);

private:
    Program program_;
    EyeBlocks blocks_;
};

/// Binds what gap_resample.glsl reads and writes of the eyes, and runs a program made of it.
void run_gap_resample(const Program& program, const GapTargets& to, PixelOrigin mark);

// What gap pixels see in mirrors and glass, by the mask of some picture, so that no other picture's colours are taken
// where that one shows something else in them from its own place. For all eyes at once.

class GapMirrors {
public:
    GapMirrors();

    /// Of all gaps whose surface `teller` sees. Returns GapTargets::image_behind, good until the next call; 0 where it
    /// does not tell.
    GLuint find(const SpecularSource& teller, const GapTargets& to);

private:
    Program program_;
    EyeBlocks blocks_;
    Size size_;
    int eyes_ = 0;
    Texture image_behind_;
};

// What a picture shows of the points that gap pixels see, for all eyes at once.

class SeenLight {
public:
    SeenLight();

    /// By the eyes' depth, which is known. Sets GapTargets::light_then and light_now, good until the next call.
    void find(const OtherPicture& then, const OtherPicture& now, GapTargets& to);

private:
    void size_for(const EyeTargets& targets);
    void look_up(const OtherPicture& picture, const GapTargets& to, const Texture& light);

    Program program_;
    EyeBlocks blocks_;
    Size size_;
    int eyes_ = 0;
    Texture then_, now_;
};

// Fill pass `patches` (fill.h) on the GPU, for all eyes at once, under GapResample's conditions.

/// Of the sphere at one of an atlas' offsets.
Pose patch_sphere_pose(const PatchesView& patches, int offset);

/// A frame's patches on the GPU, as SourceTextures are a picture.
class PatchTextures {
public:
    /// The view's pixels are read before this returns. Storage is kept as long as sizes stay.
    void upload(const PatchesView& patches, const PqView& pq = {});

    SourceTextures& atlas() { return atlas_; }
    const SourceTextures& atlas() const { return atlas_; }
    GLuint grid() const { return sphere_.grid(); }  ///< of the spheres that the patches are of
    GLuint slots() const { return slots_.name(); }  ///< as gap_samples.glsl has them

private:
    SourceTextures atlas_, sphere_;
    Size blocks_;
    int offsets_ = 0;
    Texture slots_;
    std::vector<std::int32_t> slot_numbers_;
};

class PatchResample {
public:
    PatchResample();

    /// Each eye takes first what is not mixed with what stands before it, and of the patches of the spheres around
    /// first those of the one nearest to it. Patches without depth fill nothing.
    void fill(const PatchesView& patches, const PatchTextures& textures, const GapTargets& to);

private:
    Program program_;
    EyeBlocks blocks_;
};

}  // namespace equistream::gl
