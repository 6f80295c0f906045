#pragma once
/// Engines `mesh` and `mesh-plain` (engine.h) on the GPU. Cells, and the points and triangles that they are drawn of,
/// are built in blocks: those that an eye sees and that are not there yet, or whose samples have become others. At each
/// refresh those that an eye sees are drawn, for all eyes at once.
#include "eye_depth_finder.h"

namespace equistream::gl {

class MeshDepth : public EyeDepthFinder {
public:
    explicit MeshDepth(const EngineOptions& options = {}, bool plain = false);
    ~MeshDepth() override;

    /// Blocks whose samples stay the same are kept; a change goes unnoticed in one block of 2^32.
    void forget_source() override { knows_source_ = false; }
    /// All is built anew where what cells may be off by is another by more than a step: within the head box that does
    /// not hang on where the eyes are. Waits for the GPU after a source's size changed; where more storage is needed
    /// than ever before, blocks that there was no room for are there from the next refresh on. Throws WorkError for
    /// sources of more columns or rows than max_side, and where the driver has no such storage.
    void find(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes) override;

    static constexpr int max_side = (1 << 14) - 2;

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
    void build_within(const Within& wanted);
    void forget_blocks();
    void build();
    void make_room_if_needed(bool wait);
    void run_over_blocks(const Program& program) const;
    void draw();

    bool plain_;
    Program begin_, wanted_, cells_, points_pass_, draws_pass_, draw_;
    VertexArray vertices_;
    SourceBlocks source_blocks_;
    bool is_sized_ = false;                         ///< all that hangs on the camera is there
    bool knows_source_ = false, has_room_ = false;  ///< its blocks; what sources of its size need
    /// How often `blocks_` was emptied. Under a condition the GPU may skip a build, so it compares this with the number
    /// in `counts_`, and empties those when they differ.
    int forget_number_ = 0;
    Within within_;
    Room room_;
    Texture cell_map_, depth_buffer_;
    Buffer counts_, blocks_, lists_, corners_, points_, indices_, draws_, eye_numbers_, needed_;
    const Room* needed_words_ = nullptr;  ///< of needed_, where the GPU writes
    GLsync counted_ = nullptr;
    Framebuffer framebuffer_;
};

}  // namespace equistream::gl
