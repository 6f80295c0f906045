#pragma once
/// Engine `mesh` (engine.h) on the GPU, its first half: how far away is what the eyes see, from the source's depth
/// alone? Cells, and the points and triangles that they are drawn of, are found once for each source; at each refresh
/// blocks of them that an eye sees are drawn, for all eyes at once. The second half is LookUp's.
#include "eye_blocks.h"
#include "eye_targets.h"
#include "source_textures.h"

#include <equistream_client/engine.h>

#include <span>

namespace equistream::gl {

class MeshDepth {
public:
    explicit MeshDepth(const EngineOptions& options = {});
    ~MeshDepth();
    MeshDepth(const MeshDepth&) = delete;
    MeshDepth& operator=(const MeshDepth&) = delete;

    /// The source's depth is another from now on.
    void forget_source() { is_built_ = false; }
    /// Finds the depth of eyes of one size, whose depth_m is not read; `source` has depth. Cells are built where the
    /// source is another than before, or what they may be off by is by more than a step: within the head box that does
    /// not hang on where the eyes are. Waits for the GPU after a source's size changed; where a source needs more
    /// storage than those before it, blocks that there was no room for are there from the next refresh on. Throws
    /// WorkError for sources of more columns or rows than most_side, and where the driver has no such storage. What
    /// comes after may sample texture() without a barrier of its own.
    void find(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes);
    /// Makes unknown what gap pixels of the targets see.
    void forget_gaps(const EyeTargets& targets) const;

    /// A layer for each eye; NaN where nothing was found.
    EyeDepth depth() const { return {depth_.name(), 1}; }

    static constexpr int most_side = (1 << 14) - 2;

private:
    /// What cells hang on: how far eyes may be from the source's centre, and what depth may be off by.
    struct Within {
        double box_radius_m = 0, tolerance_rad = 0;
    };
    /// What a mesh needs, or has room for.
    struct Room {
        GLuint points = 0, indices = 0;
    };

    void size_for_source(const Camera& camera);
    void size_for_eyes(Size size, int eyes);
    void make_room(Room room);
    Size blocks() const;
    void build_within(const Within& wanted);
    void build();
    void make_room_if_needed(bool wait);
    void cull();
    void draw();

    EngineOptions options_;
    Program cells_, points_pass_, cull_, draw_, forget_gaps_;
    VertexArray vertices_;
    EyeBlocks eye_blocks_;
    Camera camera_ = EquirectCamera{};
    Size source_, eye_size_;
    int eyes_ = 0;
    bool closes_ = false;
    bool is_built_ = false, has_room_ = false;  ///< for this source; what sources of its size need
    Within within_;
    Room room_;
    Texture angles_, cell_map_, corners_, depth_, depth_buffer_;
    Buffer counts_, blocks_, points_, indices_, draws_, eye_numbers_, needed_;
    const Room* needed_words_ = nullptr;  ///< of needed_, where the GPU writes
    GLsync counted_ = nullptr;
    Framebuffer framebuffer_;
};

}  // namespace equistream::gl
