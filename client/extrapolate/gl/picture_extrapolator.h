#pragma once
/// PictureExtrapolator (extrapolate.h) on the GPU. Only pixels' outlines may differ from the CPU's, by rounding.
/// Storage grows with pictures' sizes and what moves in them, and is kept. The context it was made in is current in
/// every call.
#include <client/reflections/gl/specular.h>

#include <equistream/frame.h>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include <cstdint>
#include <vector>

namespace equistream::gl {

class PictureExtrapolator {
public:
    PictureExtrapolator();

    /// What of a picture moves, and where; borrowed until the next. Again where its colours have become others.
    void set_picture(const FrameInfo& info);
    /// All is where the picture shows it; extrapolated() is of no use then.
    void rest();
    /// The picture some time later, the same one until the next set_picture(); it has depth wherever something moves
    /// and where that may come to. What it says of mirrors comes along.
    void extrapolate(const SourceTextures& picture, const SpecularTextures& specular, double seconds);

    /// What it became; depth is NaN where nothing is known.
    const SourceTextures& extrapolated() const { return extrapolated_; }
    const SpecularTextures& extrapolated_specular() const { return extrapolated_specular_; }
    /// For extrapolate_regions.glsl: the grid of the picture and the regions as they are then. Uniform block 0, storage
    /// blocks 0 and 1.
    void bind() const;
    /// Of each sample: the number of the region that is seen, 0 for none (GL_R8UI).
    GLuint regions() const { return rests_ ? map_.name() : extrapolated_map_.name(); }

private:
    /// As std430 has it (extrapolate_regions.glsl).
    struct RegionBlock {
        glm::mat4 forward, backward;
        glm::vec4 depths, velocity, turning;
    };

    void size_for(Size size);
    void mark();
    void copy(const SourceTextures& picture, const SpecularTextures& specular);
    void list_tiles();
    void upload_regions(double seconds);
    void run_over_pieces(const Program& program) const;

    Program mark_, splat_, list_, show_;
    const FrameInfo* info_ = nullptr;
    bool marked_ = false, is_copied_ = false, rests_ = true;
    Size size_;
    Texture map_, candidates_, extrapolated_map_;
    SourceTextures extrapolated_;
    SpecularTextures extrapolated_specular_;
    std::vector<RegionBlock> blocks_;
    std::vector<glm::uvec2> pieces_;
    std::size_t piece_room_ = 0, tile_count_ = 0;
    Buffer regions_, piece_buffer_, tiles_;
};

}  // namespace equistream::gl
