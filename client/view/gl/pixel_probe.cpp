#include "pixel_probe.h"

#include <cstddef>
#include <cstring>

namespace equistream::gl {

namespace {

/// Where each value comes to lie.
struct Answer {
    std::array<std::uint8_t, 4> rgba;
    std::uint8_t origin, unused[3];
    float inverse, reliability;
};

}  // namespace

PixelProbe::PixelProbe() : buffer_(make_buffer(sizeof(Answer), GL_MAP_READ_BIT | GL_CLIENT_STORAGE_BIT)) {}

PixelProbe::~PixelProbe() {
    if (fence_ != nullptr)
        glDeleteSync(fence_);
}

void PixelProbe::ask(const ShownPixel& pixel, const EyeTargets& eyes, const EyeDepth& depth, GLuint reliability) {
    const Size size = eyes.size();
    if (is_waiting() || pixel.x < 0 || pixel.y < 0 || pixel.x >= size.width || pixel.y >= size.height ||
        pixel.eye >= eyes.eyes())
        return;
    const auto read = [&](GLuint texture, GLenum format, GLenum type, std::size_t offset) {
        glGetTextureSubImage(texture, 0, pixel.x, pixel.y, pixel.eye, 1, 1, 1, format, type,
                             GLsizei(sizeof(Answer) - offset), reinterpret_cast<void*>(offset));
    };
    glBindBuffer(GL_PIXEL_PACK_BUFFER, buffer_.name());
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    read(eyes.colour(), GL_RGBA, GL_UNSIGNED_BYTE, offsetof(Answer, rgba));
    read(eyes.origin(), GL_RED_INTEGER, GL_UNSIGNED_BYTE, offsetof(Answer, origin));
    if (depth.texture != 0)
        read(depth.texture, depth.format, GL_FLOAT, offsetof(Answer, inverse));
    if (reliability != 0)
        read(reliability, GL_RED, GL_FLOAT, offsetof(Answer, reliability));
    glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    fence_ = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    asked_ = {};
    asked_.pixel = pixel;
    if (depth.texture != 0)
        asked_.inverse_m = depth.scale;
    if (reliability != 0)
        asked_.reliability = 0;
}

std::optional<PixelValues> PixelProbe::take() {
    if (fence_ == nullptr || glClientWaitSync(fence_, GL_SYNC_FLUSH_COMMANDS_BIT, 0) == GL_TIMEOUT_EXPIRED)
        return std::nullopt;
    glDeleteSync(fence_);
    fence_ = nullptr;
    Answer answer{};
    glGetNamedBufferSubData(buffer_.name(), 0, sizeof(answer), &answer);
    PixelValues values = asked_;
    values.rgba = answer.rgba;
    values.origin = answer.origin;
    if (values.inverse_m)
        *values.inverse_m *= answer.inverse;
    if (values.reliability)
        values.reliability = answer.reliability;
    return values;
}

}  // namespace equistream::gl
