#include "pq_display.h"

#include <equistream/error.h>
#include <equistream/formatted.h>
#include <equistream/pq.h>

#include <algorithm>
#include <stdexcept>

namespace equistream::gl {

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
