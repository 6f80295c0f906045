#include "pixel_list.h"

#include <array>

namespace equistream::gl {

namespace {

/// What stands before the pixels, as pixel_list.glsl has it: work groups, and the count.
using ListHead = std::array<GLuint, 4>;
constexpr ListHead nothing_listed = {0, 1, 1, 0};
constexpr GLuint list_unit = 8;

}  // namespace

PixelList::PixelList() : groups_({{GL_COMPUTE_SHADER, "pixel_list_groups.glsl"}}) {}

void PixelList::size_for(std::size_t pixels) {
    if (pixels <= pixels_)
        return;
    list_ = make_buffer(sizeof(ListHead) + pixels * sizeof(GLuint), GL_DYNAMIC_STORAGE_BIT);
    pixels_ = pixels;
}

void PixelList::start() const {
    // The last list was written by a shader.
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glNamedBufferSubData(list_.name(), 0, sizeof nothing_listed, nothing_listed.data());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, list_unit, list_.name());
}

void PixelList::dispatch(const Program& program) const {
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    groups_.dispatch({1, 1});
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
    program.dispatch_indirect(list_.name(), 0);
}

}  // namespace equistream::gl
