#include "source_textures.h"

#include "../warp.h"

#include <cassert>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace equistream::gl {

namespace {

/// As std140 has it.
struct GridBlock {
    GLint width, height, is_sphere, closes, north_pole, south_pole;
    GLfloat focal_px, middle, top, columns_per_radian, rows_per_radian, unused = 0;
};

GridBlock block_of(const SourceGrid& grid) {
    return {grid.width,          grid.height,   grid.sphere, grid.closes, grid.north_pole,
            grid.south_pole,     grid.focal_px, grid.middle, grid.top,    grid.columns_per_radian,
            grid.rows_per_radian};
}

struct PixelType {
    GLenum format, type;
};

/// Rows may lie anywhere in memory that a whole number of samples apart reaches.
template <typename T>
void upload_plane(const Texture& texture, const ImageView<const T>& plane, PixelType pixels) {
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glPixelStorei(GL_UNPACK_ROW_LENGTH, GLint(plane.row_stride / plane.channels));
    glTextureSubImage2D(texture.name(), 0, 0, 0, plane.width, plane.height, pixels.format, pixels.type, plane.data);
    glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
}

std::vector<std::string> yuv_defines() {
    const auto define = [](const char* name, int value) { return std::string(name) + " " + std::to_string(value); };
    using namespace yuv_to_rgb;
    return {define("SUM_BITS", sum_bits),
            define("LUMA_GAIN", luma_gain),
            define("OFFSET", offset),
            define("RED_FROM_CR", red_from_cr),
            define("BLUE_FROM_CB", blue_from_cb),
            define("GREEN_FROM_CB", yuv_to_rgb::green_from_cb),
            define("GREEN_FROM_CR", yuv_to_rgb::green_from_cr)};
}

}  // namespace

SourceTextures::SourceTextures()
    : yuv_to_rgb_({{GL_COMPUTE_SHADER, "yuv_to_rgb.glsl"}}, yuv_defines()),
      grid_(make_buffer(sizeof(GridBlock), GL_DYNAMIC_STORAGE_BIT)) {}

void SourceTextures::describe(const Camera& camera) {
    const Size size{width_of(camera), height_of(camera)};
    if (!(size == size_)) {
        size_ = size;
        colour_ = {};
        depth_ = {};
        has_depth_ = false;
        planes_ = {};
        planes_storage_ = GL_NONE;
    }
    const GridBlock block = block_of(source_grid(camera));
    glNamedBufferSubData(grid_.name(), 0, sizeof block, &block);
}

void SourceTextures::forget_depth() {
    has_depth_ = false;
    depth_to_write();
}

void SourceTextures::upload(const SourceView& source, const PqView& pq) {
    describe(source.camera);
    colour_to_write();
    if (source.rgb.data != nullptr)
        upload_rgb(source.rgb);
    else if (!source.yuv.empty())
        upload_yuv(source.yuv);
    else
        upload_pq(pq);
    has_depth_ = source.depth_m.data != nullptr;
    if (!has_depth_)
        return;
    make_depth();
    upload_plane(depth_, source.depth_m, {GL_RED, GL_FLOAT});
}

GLuint SourceTextures::colour_to_write() {
    if (!colour_)
        colour_ = make_texture(size_, GL_RGBA8);
    return colour_.name();
}

void SourceTextures::make_depth() {
    if (!depth_)
        depth_ = make_texture(size_, GL_R32F);
}

GLuint SourceTextures::depth_to_write() {
    if (!has_depth_) {
        make_depth();
        const float unknown = std::nanf("");
        glClearTexImage(depth_.name(), 0, GL_RED, GL_FLOAT, &unknown);
        has_depth_ = true;
    }
    return depth_.name();
}

void SourceTextures::upload_rgb(const ImageView<const std::uint8_t>& rgb) {
    assert(rgb.row_stride % rgb.channels == 0);
    planes_storage_ = GL_NONE;
    const GLenum format = rgb.channels == 4 ? GL_RGBA : GL_RGB;
    upload_plane(colour_, rgb, {format, GL_UNSIGNED_BYTE});
}

template <typename T>
void SourceTextures::upload_planes(const Yuv420View<T>& yuv, GLenum storage, GLenum type) {
    if (storage != std::exchange(planes_storage_, storage))
        planes_ = {};
    const std::array planes = {yuv.y, yuv.cb, yuv.cr};
    for (std::size_t i = 0; i < planes.size(); ++i) {
        if (!planes_[i])
            planes_[i] = make_texture({planes[i].width, planes[i].height}, storage);
        upload_plane(planes_[i], planes[i], {GL_RED_INTEGER, type});
    }
}

void SourceTextures::upload_pq(const PqView& pq) {
    upload_planes(pq, GL_R16UI, GL_UNSIGNED_SHORT);
    show_again();
}

void SourceTextures::show_again() {
    if (planes_storage_ != GL_R16UI)
        return;
    assert(pq_display_ != nullptr);
    pq_display_->convert(planes_, colour_, size_);
}

void SourceTextures::upload_yuv(const YuvView& yuv) {
    upload_planes(yuv, GL_R8UI, GL_UNSIGNED_BYTE);
    for (std::size_t i = 0; i < planes_.size(); ++i)
        glBindTextureUnit(GLuint(i), planes_[i].name());
    glBindImageTexture(0, colour_.name(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8);
    yuv_to_rgb_.dispatch(size_);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

}  // namespace equistream::gl
