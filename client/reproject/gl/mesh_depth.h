#pragma once
/// Engine `mesh` (engine.h) on the GPU. Cells, and the points and triangles that they are drawn of, are found once for
/// each source; at each refresh blocks of them that an eye sees are drawn, for all eyes at once.
#include "eye_depth_finder.h"

namespace equistream::gl {

class MeshDepth : public EyeDepthFinder {
public:
    explicit MeshDepth(const EngineOptions& options = {});
    ~MeshDepth() override;

    void forget_source() override { is_built_ = false; }
    /// Cells are built where the source is another than before, or what they may be off by is by more than a step:
    /// within the head box that does not hang on where the eyes are. Waits for the GPU after a source's size changed;
    /// where a source needs more storage than those before it, blocks that there was no room for are there from the
    /// next refresh on. Throws WorkError for sources of more columns or rows than most_side, and where the driver has
    /// no such storage.
    void find(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes) override;

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

    Program cells_, points_pass_, cull_, draw_;
    VertexArray vertices_;
    bool closes_ = false;
    bool is_built_ = false, has_room_ = false;  ///< for this source; what sources of its size need
    Within within_;
    Room room_;
    Texture cell_map_, corners_, depth_buffer_;
    Buffer counts_, blocks_, points_, indices_, draws_, eye_numbers_, needed_;
    const Room* needed_words_ = nullptr;  ///< of needed_, where the GPU writes
    GLsync counted_ = nullptr;
    Framebuffer framebuffer_;
};

}  // namespace equistream::gl
