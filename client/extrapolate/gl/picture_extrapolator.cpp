#include "picture_extrapolator.h"

#include <client/extrapolate/extrapolate.h>

#include <equistream/text.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <span>
#include <string>

namespace equistream::gl {

namespace {

/// Threads that a run's piece is worked on by.
constexpr int piece_pixels = 64;
/// Work groups in a row; drivers need not take more than 65,535.
constexpr std::size_t max_groups_in_row = 1024;

/// As extrapolate_tiles.glsl has it, before the tiles.
struct TilesHead {
    std::array<GLuint, 3> groups{0, 1, 1};
    GLuint listed = 0;
};

std::vector<std::string> defines() {
    return {formatted("PIECE %d", piece_pixels), formatted("MAX_EXTRAPOLATED_M float(%.9g)", max_extrapolated_m),
            formatted("MAX_HALF_HEIGHT float(%.9g)", max_half_height)};
}

void copy_texture(GLuint from, GLuint to, Size size) {
    glCopyImageSubData(from, GL_TEXTURE_2D, 0, 0, 0, 0, to, GL_TEXTURE_2D, 0, 0, 0, 0, size.width, size.height, 1);
}

glm::mat4 matrix_of(const RigidTransform& transform) {
    glm::dmat4 matrix(transform.rotation);
    matrix[3] = glm::dvec4(transform.translation_m, 1);
    return glm::mat4(matrix);
}

}  // namespace

PictureExtrapolator::PictureExtrapolator()
    : mark_("extrapolate_mark.glsl", defines()), splat_("extrapolate_splat.glsl", defines()),
      list_("extrapolate_list.glsl"), show_("extrapolate_show.glsl"),
      regions_(make_buffer(max_moving_regions * sizeof(RegionBlock), GL_DYNAMIC_STORAGE_BIT)) {
    blocks_.reserve(max_moving_regions);
}

void PictureExtrapolator::set_picture(const FrameInfo& info) {
    assert(info.moving.size() <= std::size_t{max_moving_regions});
    info_ = &info;
    marked_ = is_copied_ = false;
}

void PictureExtrapolator::size_for(Size size) {
    if (size == size_)
        return;
    size_ = {};  // what fails half-way is begun anew
    map_ = make_texture(size, GL_R8UI);
    extrapolated_map_ = make_texture(size, GL_R8UI);
    candidates_ = make_texture(size, GL_R32UI);
    const GLuint none = ~GLuint{0};
    glClearTexImage(candidates_.name(), 0, GL_RED_INTEGER, GL_UNSIGNED_INT, &none);
    tile_count_ = std::size_t((size.width + group_width - 1) / group_width) *
                  std::size_t((size.height + group_height - 1) / group_height);
    tiles_ = make_buffer(sizeof(TilesHead) + 2 * tile_count_ * sizeof(GLuint), GL_DYNAMIC_STORAGE_BIT);
    size_ = size;
}

void PictureExtrapolator::run_over_pieces(const Program& program) const {
    const std::size_t columns = std::min(pieces_.size(), max_groups_in_row);
    if (columns == 0)
        return;
    program.set("piece_count", int(pieces_.size()));
    program.use();
    glDispatchCompute(GLuint(columns), GLuint((pieces_.size() + columns - 1) / columns), 1);
}

void PictureExtrapolator::bind() const {
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, extrapolated_.grid());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, regions_.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, piece_buffer_.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, tiles_.name());
}

/// Once a picture.
void PictureExtrapolator::mark() {
    extrapolated_.describe(info_->camera);
    size_for(extrapolated_.size());
    pieces_.clear();
    for (std::size_t k = 0; k < info_->moving.size(); ++k)
        for (const PixelRun& run : info_->moving[k].runs)
            for (int begin = run.begin; begin < run.end; begin += piece_pixels)
                pieces_.emplace_back(GLuint(run.row) << 16 | GLuint(begin),
                                     GLuint(k + 1) << 8 | GLuint(std::min(piece_pixels, run.end - begin)));
    if (pieces_.size() > piece_room_ || piece_room_ == 0) {
        const std::size_t room = std::max<std::size_t>(1, 2 * pieces_.size());
        piece_buffer_ = make_buffer(room * sizeof(glm::uvec2), GL_DYNAMIC_STORAGE_BIT);
        piece_room_ = room;
    }
    glNamedBufferSubData(piece_buffer_.name(), 0, GLsizeiptr(pieces_.size() * sizeof(glm::uvec2)), pieces_.data());
    const GLuint none = 0;
    glClearTexImage(map_.name(), 0, GL_RED_INTEGER, GL_UNSIGNED_INT, &none);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glClearNamedBufferData(tiles_.name(), GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, &none);
    bind();
    glBindImageTexture(0, map_.name(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R8UI);
    run_over_pieces(mark_);
    marked_ = true;
}

void PictureExtrapolator::upload_regions(double seconds) {
    blocks_.clear();
    const glm::dmat3 camera_from_world = glm::transpose(glm::mat3_cast(info_->camera_pose.orientation));
    for (const MovingRegion& region : info_->moving) {
        const MovedRegion moved(region, *info_, seconds);
        const Twist &now = region.motion.twist, &change = region.motion.twist_per_second;
        blocks_.push_back(
            {matrix_of(moved.forward()),
             matrix_of(moved.backward()),
             {region.near_m, region.far_m, 0, 0},
             glm::vec4(glm::vec3(camera_from_world * (now.velocity_m_s + seconds * change.velocity_m_s)), 0),
             glm::vec4(glm::vec3(camera_from_world * (now.angular_rad_s + seconds * change.angular_rad_s)), 0)});
    }
    glNamedBufferSubData(regions_.name(), 0, GLsizeiptr(blocks_.size() * sizeof(RegionBlock)), blocks_.data());
}

void PictureExtrapolator::rest() {
    assert(info_ != nullptr);
    rests_ = true;
    if (!marked_)
        mark();
    upload_regions(0);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

/// Once a picture that is extrapolated: from then on only tiles that are not as it shows them are written.
void PictureExtrapolator::copy(const SourceTextures& picture, const SpecularTextures& specular) {
    const GLuint none = 0;
    extrapolated_specular_.size_for(size_, specular.has_mask());
    // Passes may have made the one, and have made the other.
    glMemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
    copy_texture(picture.colour(), extrapolated_.colour_to_write(), size_);
    copy_texture(picture.depth(), extrapolated_.depth_to_write(), size_);
    glClearTexImage(extrapolated_map_.name(), 0, GL_RED_INTEGER, GL_UNSIGNED_INT, &none);
    if (specular.has_mask()) {
        copy_texture(specular.mask(), extrapolated_specular_.mask(), size_);
        copy_texture(specular.virtual_depth(), extrapolated_specular_.virtual_depth(), size_);
    }
    is_copied_ = true;
}

void PictureExtrapolator::list_tiles() {
    const TilesHead none;
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    glNamedBufferSubData(tiles_.name(), 0, sizeof none, &none);
    list_.use();
    glDispatchCompute(GLuint((tile_count_ + 63) / 64), 1, 1);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
}

void PictureExtrapolator::extrapolate(const SourceTextures& picture, const SpecularTextures& specular, double seconds) {
    assert(info_ != nullptr && picture.depth() != 0);
    if (!marked_)
        mark();
    if (!is_copied_)
        copy(picture, specular);
    assert(picture.size() == size_);
    rests_ = false;
    upload_regions(seconds);
    bind();
    glBindTextureUnit(0, picture.depth());
    glBindImageTexture(0, candidates_.name(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_R32UI);
    // The candidates of the time before were taken back by a shader, and regions were marked by one.
    glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
    run_over_pieces(splat_);
    list_tiles();
    glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    glBindTextureUnit(0, picture.colour());
    glBindTextureUnit(1, picture.depth());
    glBindTextureUnit(2, map_.name());
    glBindImageTexture(1, extrapolated_.colour_to_write(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8);
    glBindImageTexture(2, extrapolated_.depth_to_write(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
    glBindImageTexture(3, extrapolated_map_.name(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R8UI);
    show_.set("has_mask", int(specular.has_mask()));
    if (specular.has_mask()) {
        glBindTextureUnit(3, specular.mask());
        glBindTextureUnit(4, specular.virtual_depth());
        glBindImageTexture(4, extrapolated_specular_.mask(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
        glBindImageTexture(5, extrapolated_specular_.virtual_depth(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
    }
    show_.dispatch_indirect(tiles_.name(), offsetof(TilesHead, groups));
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

}  // namespace equistream::gl
