#pragma once
/// Whether anything is made on the GPU.
#include <epoxy/gl.h>

namespace equistream::test {

/// Counts what is made while it lives. Each of the calls must have been made before: only then its pointer is the
/// driver's and not one that looks it up.
class MadeObjects {
public:
    MadeObjects() {
        count_ = 0;
        textures_ = epoxy_glCreateTextures;
        buffers_ = epoxy_glCreateBuffers;
        framebuffers_ = epoxy_glCreateFramebuffers;
        program_ = epoxy_glCreateProgram;
        compile_ = epoxy_glCompileShader;
        epoxy_glCreateTextures = [](GLenum target, GLsizei n, GLuint* names) { ++count_, textures_(target, n, names); };
        epoxy_glCreateBuffers = [](GLsizei n, GLuint* names) { ++count_, buffers_(n, names); };
        epoxy_glCreateFramebuffers = [](GLsizei n, GLuint* names) { ++count_, framebuffers_(n, names); };
        epoxy_glCreateProgram = [] { return ++count_, program_(); };
        epoxy_glCompileShader = [](GLuint shader) { ++count_, compile_(shader); };
    }
    ~MadeObjects() {
        epoxy_glCreateTextures = textures_;
        epoxy_glCreateBuffers = buffers_;
        epoxy_glCreateFramebuffers = framebuffers_;
        epoxy_glCreateProgram = program_;
        epoxy_glCompileShader = compile_;
    }
    MadeObjects(const MadeObjects&) = delete;
    MadeObjects& operator=(const MadeObjects&) = delete;
    int count() const { return count_; }

private:
    static inline int count_ = 0;
    static inline decltype(epoxy_glCreateTextures) textures_ = nullptr;
    static inline decltype(epoxy_glCreateBuffers) buffers_ = nullptr;
    static inline decltype(epoxy_glCreateFramebuffers) framebuffers_ = nullptr;
    static inline decltype(epoxy_glCreateProgram) program_ = nullptr;
    static inline decltype(epoxy_glCompileShader) compile_ = nullptr;
};

}  // namespace equistream::test
