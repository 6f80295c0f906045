#pragma once
/// Engine `mesh` (engine.h) on the GPU, its first half: how far away is what the eyes see, from the source's depth
/// alone? Cells are built once for each source, triangles drawn for all eyes at once. The second half is LookUp's.
#include "eye_blocks.h"
#include "eye_targets.h"
#include "source_textures.h"

#include <equistream_client/engine.h>

#include <span>

namespace equistream::gl {

class MeshDepth {
public:
    explicit MeshDepth(const EngineOptions& options = {});

    /// The source's depth is another from now on.
    void forget_source() { built_ = {}; }
    /// Finds the depth of eyes of one size, whose depth_m is not read; `source` has depth. Cells are built where the
    /// source or what they may be off by is another than before: within the head box that does not hang on where the
    /// eyes are. Throws WorkError for sources of more columns or rows than most_side. What comes after may sample
    /// texture() without a barrier of its own.
    void find(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes);
    /// Makes unknown what gap pixels of the targets see.
    void forget_gaps(const EyeTargets& targets) const;

    /// A layer for each eye; NaN where nothing was found.
    EyeDepth depth() const { return {depth_.name(), 1}; }

    static constexpr int most_side = (1 << 14) - 2;

private:
    /// What cells hang on.
    struct Within {
        float box_radius_m = -1, tolerance = 0, share = 0;
        bool operator==(const Within&) const = default;
    };

    void size_for_source(const Camera& camera);
    void size_for_eyes(Size size, int eyes);
    void bind_lists() const;
    void build(const Within& within);
    void draw(const Within& within);

    EngineOptions options_;
    Program cells_, fans_, draw_, forget_gaps_;
    VertexArray no_vertices_;
    EyeBlocks eye_blocks_;
    Camera camera_ = EquirectCamera{};
    Size source_, eye_size_;
    int eyes_ = 0;
    bool closes_ = false;
    Within built_;
    Texture angles_, corners_, depth_, depth_buffer_;
    Buffer lists_, quads_, fans_list_, cuts_, large_;
    Framebuffer framebuffer_;
};

}  // namespace equistream::gl
