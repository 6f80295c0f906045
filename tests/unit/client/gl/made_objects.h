#pragma once
/// Whether anything is made on the GPU.
#include <epoxy/gl.h>

#include <array>
#include <cstdint>
#include <utility>

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

/// While it lives the driver has memory for so many more textures and buffers. One at a time.
class NoMemory {
public:
    explicit NoMemory(int more = 0) {
        calls_ = 2 * more + 1;  // errors are asked for before storage and after it
        original_ = std::exchange(epoxy_glGetError,
                                  [] { return calls_-- > 0 ? GLenum(GL_NO_ERROR) : GLenum(GL_OUT_OF_MEMORY); });
    }
    ~NoMemory() { epoxy_glGetError = original_; }
    NoMemory(const NoMemory&) = delete;
    NoMemory& operator=(const NoMemory&) = delete;

private:
    static inline int calls_ = 0;
    static inline decltype(epoxy_glGetError) original_ = nullptr;
};

// How much work passes were given by the GPU itself.

/// Work groups that indirect passes had while it lives. One at a time.
class IndirectGroups {
public:
    IndirectGroups() {
        count_ = 0;
        original_ = epoxy_glDispatchComputeIndirect;
        epoxy_glDispatchComputeIndirect = counting;
    }
    ~IndirectGroups() { epoxy_glDispatchComputeIndirect = original_; }
    IndirectGroups(const IndirectGroups&) = delete;
    IndirectGroups& operator=(const IndirectGroups&) = delete;
    std::int64_t count() const { return count_; }

private:
    static void counting(GLintptr offset) {
        GLint buffer = 0;
        glGetIntegerv(GL_DISPATCH_INDIRECT_BUFFER_BINDING, &buffer);
        std::array<GLuint, 3> groups{};
        glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
        glGetNamedBufferSubData(GLuint(buffer), offset, sizeof groups, groups.data());
        count_ += std::int64_t(groups[0]) * groups[1] * groups[2];
        // libepoxy's pointer looks its function up when it is called first, and overwrites itself.
        epoxy_glDispatchComputeIndirect = original_;
        original_(offset);
        original_ = std::exchange(epoxy_glDispatchComputeIndirect, counting);
    }

    static inline std::int64_t count_ = 0;
    static inline decltype(epoxy_glDispatchComputeIndirect) original_ = nullptr;
};

}  // namespace equistream::test
