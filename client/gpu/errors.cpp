#include "errors.h"

#include "context.h"

#include <epoxy/gl.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>

namespace equistream::gl {

namespace {

std::atomic<bool> is_wanted = false;

void GLAPIENTRY on_message(GLenum source, GLenum type, GLuint, GLenum, GLsizei, const GLchar* message, const void*) {
    // Programs throw what their compiler says.
    if (source == GL_DEBUG_SOURCE_SHADER_COMPILER || type != GL_DEBUG_TYPE_ERROR)
        return;
    std::fprintf(stderr, "OpenGL: %s\n", message);
    std::abort();
}

}  // namespace

bool errors_abort() {
    return is_wanted;
}

void watch_errors() {
    glEnable(GL_DEBUG_OUTPUT);
    glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    glDebugMessageCallback(on_message, nullptr);
}

void abort_on_errors() {
    is_wanted = true;
}

bool Driver::is_software() const {
    return renderer.starts_with("llvmpipe") || renderer.starts_with("softpipe");
}

Driver Context::driver() {
    const auto text = [](GLenum name) {
        const GLubyte* found = glGetString(name);
        return found != nullptr ? std::string(reinterpret_cast<const char*>(found)) : std::string();
    };
    return {text(GL_VENDOR), text(GL_RENDERER), text(GL_VERSION)};
}

}  // namespace equistream::gl
