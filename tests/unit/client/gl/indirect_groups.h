#pragma once
/// How much work passes were given by the GPU itself.
#include <epoxy/gl.h>

#include <array>
#include <cstdint>
#include <utility>

namespace equistream::test {

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
