#include "source_textures.h"

#include <equistream/error.h>
#include <equistream/text.h>
#include <equistream/yuv.h>

#include <client/gpu/context.h>
#include <client/warp/resample.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <stdexcept>
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

/// Rows may lie anywhere in memory that a whole number of samples apart reaches, or in a buffer at `place`.
template <typename T>
void upload_plane(const Texture& texture, const ImageView<const T>& plane, PixelType pixels,
                  const std::optional<PictureBuffers::Place>& place = std::nullopt) {
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glPixelStorei(GL_UNPACK_ROW_LENGTH, GLint(plane.row_stride / plane.channels));
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, place ? place->buffer : 0);
    const void* const from = place ? reinterpret_cast<const void*>(place->offset) : plane.data;
    glTextureSubImage2D(texture.name(), 0, 0, 0, plane.width, plane.height, pixels.format, pixels.type, from);
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
}

Program yuv_program(bool in_one_buffer) {
    const auto define = [](const char* name, int value) { return std::string(name) + " " + std::to_string(value); };
    using namespace yuv_to_rgb;
    std::vector<std::string> defines = {define("SUM_BITS", sum_bits),
                                        define("LUMA_GAIN", luma_gain),
                                        define("OFFSET", offset),
                                        define("RED_FROM_CR", red_from_cr),
                                        define("BLUE_FROM_CB", blue_from_cb),
                                        define("GREEN_FROM_CB", yuv_to_rgb::green_from_cb),
                                        define("GREEN_FROM_CR", yuv_to_rgb::green_from_cr)};
    if (in_one_buffer)
        defines.push_back("IN_ONE_BUFFER");
    return Program("yuv_to_rgb.glsl", defines);
}

}  // namespace

SourceTextures::SourceTextures(PlaneReader reader)
    : on_cpu_(reader == PlaneReader::by_driver ? Context::driver().is_software() : reader == PlaneReader::cpu),
      grid_(make_buffer(sizeof(GridBlock), GL_DYNAMIC_STORAGE_BIT)) {}

void SourceTextures::describe(const Camera& camera) {
    const Size size{width_of(camera), height_of(camera)};
    if (!(size == size_)) {
        size_ = size;
        colour_ = {};
        depth_ = {};
        has_depth_ = false;
        planes_ = {};
        is_pq_ = false;
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
    is_pq_ = source.rgb.data == nullptr && source.yuv.empty();
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

void SourceTextures::swap_pictures(SourceTextures& other) {
    std::swap(size_, other.size_);
    std::swap(colour_, other.colour_);
    std::swap(depth_, other.depth_);
    std::swap(has_depth_, other.has_depth_);
    std::swap(planes_, other.planes_);
    std::swap(planes_storage_, other.planes_storage_);
    std::swap(is_pq_, other.is_pq_);
    std::swap(grid_, other.grid_);
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
        upload_plane(planes_[i], planes[i], {GL_RED_INTEGER, type},
                     buffers_ ? buffers_->find(planes[i].data) : std::nullopt);
    }
    if (buffers_)
        buffers_->was_read(yuv.y.data);
}

void SourceTextures::upload_pq(const PqView& pq) {
    upload_planes(pq, GL_R16UI, GL_UNSIGNED_SHORT);
    show_again();
}

void SourceTextures::show_again() {
    if (!is_pq_)
        return;
    assert(pq_display_ != nullptr);
    pq_display_->convert(planes_, colour_, size_);
}

void SourceTextures::upload_yuv(const YuvView& yuv) {
    if (buffers_ && convert_in_place(yuv))
        return;
    if (on_cpu_) {
        if (rgba_.width() != size_.width || rgba_.height() != size_.height)
            rgba_ = ByteImage(size_.width, size_.height, 4);
        yuv420_to_rgb(yuv, rgba_.view());
        upload_rgb(rgba_.view());
        return;
    }
    upload_planes(yuv, GL_R8UI, GL_UNSIGNED_BYTE);
    for (std::size_t i = 0; i < planes_.size(); ++i)
        glBindTextureUnit(GLuint(i), planes_[i].name());
    if (!from_textures_)
        from_textures_ = yuv_program(false);
    run(*from_textures_);
}

/// False where the planes lie elsewhere.
bool SourceTextures::convert_in_place(const YuvView& yuv) {
    const auto y = buffers_->find(yuv.y.data), cb = buffers_->find(yuv.cb.data), cr = buffers_->find(yuv.cr.data);
    if (!y || !cb || !cr || cb->buffer != y->buffer || cr->buffer != y->buffer)
        return false;
    if (!from_buffer_)
        from_buffer_ = yuv_program(true);
    const auto place = [](const PictureBuffers::Place& at, const ImageView<const std::uint8_t>& plane) {
        return glm::ivec2(int(at.offset), int(plane.row_stride));
    };
    from_buffer_->set("luma_place", place(*y, yuv.y));
    from_buffer_->set("cb_place", place(*cb, yuv.cb));
    from_buffer_->set("cr_place", place(*cr, yuv.cr));
    from_buffer_->set("chroma_size", glm::ivec2(yuv.cb.width, yuv.cb.height));
    glBindTextureUnit(0, y->bytes);
    run(*from_buffer_);
    buffers_->was_read(yuv.y.data);
    return true;
}

void SourceTextures::run(const Program& yuv_to_rgb) {
    glBindImageTexture(0, colour_.name(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8);
    yuv_to_rgb.dispatch(size_);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

namespace {

/// Those of the planes come before.
constexpr GLuint first_table_unit = 3;

std::vector<std::string> pq_defines() {
    using namespace bt2020;
    const auto define = [](const char* name, double value) { return formatted("%s float(%.9g)", name, value); };
    return {define("LUMA_BLACK", luma_black),       define("LUMA_SCALE", luma_scale),
            define("CHROMA_MIDDLE", chroma_middle), define("CHROMA_SCALE", chroma_scale),
            define("RED_FROM_CR", cr_divisor),      define("BLUE_FROM_CB", cb_divisor),
            define("GREEN_FROM_CB", green_from_cb), define("GREEN_FROM_CR", green_from_cr)};
}

Sampler make_sampler(GLint filter) {
    GLuint name = 0;
    glCreateSamplers(1, &name);
    Sampler sampler(name);
    for (const GLenum what : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
        glSamplerParameteri(name, what, filter);
    for (const GLenum what : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R})
        glSamplerParameteri(name, what, GL_CLAMP_TO_EDGE);
    return sampler;
}

Texture make_table(const ShaderTable& table) {
    const GLenum target = table.depth > 0 ? GL_TEXTURE_3D : table.height > 0 ? GL_TEXTURE_2D : GL_TEXTURE_1D;
    GLint most = 0;
    glGetIntegerv(table.depth > 0 ? GL_MAX_3D_TEXTURE_SIZE : GL_MAX_TEXTURE_SIZE, &most);
    if (std::max({table.width, table.height, table.depth}) > most)
        throw InputError(expected_found("OpenColorIO's view", formatted("tables of at most %d a side, here", most),
                                        formatted("%dx%dx%d", table.width, table.height, table.depth)));
    GLuint name = 0;
    glCreateTextures(target, 1, &name);
    Texture texture(name);
    const GLenum storage = table.channels == 1 ? GL_R32F : GL_RGB32F, format = table.channels == 1 ? GL_RED : GL_RGB;
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    if (target == GL_TEXTURE_3D) {
        glTextureStorage3D(name, 1, storage, table.width, table.height, table.depth);
        glTextureSubImage3D(name, 0, 0, 0, 0, table.width, table.height, table.depth, format, GL_FLOAT,
                            table.values.data());
    } else if (target == GL_TEXTURE_2D) {
        glTextureStorage2D(name, 1, storage, table.width, table.height);
        glTextureSubImage2D(name, 0, 0, 0, table.width, table.height, format, GL_FLOAT, table.values.data());
    } else {
        glTextureStorage1D(name, 1, storage, table.width);
        glTextureSubImage1D(name, 0, 0, table.width, format, GL_FLOAT, table.values.data());
    }
    return texture;
}

/// The view is the user's: what its shader asks for may be more than a driver has.
Program make_program(const DisplayShader& shader) {
    GLint units = 0;
    glGetIntegerv(GL_MAX_COMPUTE_TEXTURE_IMAGE_UNITS, &units);
    const int most = units - int(first_table_unit);
    if (int(shader.tables.size()) > most)
        throw InputError(expected_found("OpenColorIO's view", formatted("at most %d tables, here", most),
                                        std::to_string(shader.tables.size())));
    const std::string text = shader.text + "\n" + shader_text("pq_to_rgb.glsl");
    try {
        return Program({{GL_COMPUTE_SHADER, "pq_to_rgb.glsl", text}}, pq_defines());
    } catch (const std::logic_error& error) {
        const std::string said = error.what();
        throw InputError(
            expected_found("OpenColorIO's view", "a shader that this driver takes", said.substr(0, said.find('\n'))));
    }
}

}  // namespace

PqDisplay::PqDisplay(const HdrDisplay& display) : PqDisplay(display.shader(), display.settings().exposure_stops) {}

PqDisplay::PqDisplay(const DisplayShader& shader, double exposure_stops)
    : program_(make_program(shader)), exposure_uniform_(shader.exposure_uniform), linear_(make_sampler(GL_LINEAR)),
      nearest_(make_sampler(GL_NEAREST)) {
    for (const ShaderTable& table : shader.tables) {
        if (!program_.reads(table.sampler.c_str()))
            continue;
        const GLuint unit = first_table_unit + GLuint(tables_.size());
        program_.set(table.sampler.c_str(), int(unit));
        tables_.push_back({make_table(table), table.linear ? linear_.name() : nearest_.name()});
    }
    set_exposure(exposure_stops);
}

void PqDisplay::set_exposure(double stops) {
    exposure_stops_ = std::clamp(stops, -max_exposure_stops, max_exposure_stops);
    program_.set(exposure_uniform_.c_str(), float(exposure_stops_));
}

void PqDisplay::convert(const std::array<Texture, 3>& planes, const Texture& colour, Size size) const {
    for (std::size_t i = 0; i < planes.size(); ++i)
        glBindTextureUnit(GLuint(i), planes[i].name());
    for (std::size_t i = 0; i < tables_.size(); ++i) {
        glBindTextureUnit(first_table_unit + GLuint(i), tables_[i].texture.name());
        glBindSampler(first_table_unit + GLuint(i), tables_[i].sampler);
    }
    glBindImageTexture(0, colour.name(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8);
    program_.dispatch(size);
    for (std::size_t i = 0; i < tables_.size(); ++i)
        glBindSampler(first_table_unit + GLuint(i), 0);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

}  // namespace equistream::gl
