#pragma once
/// Every call that makes something on the GPU or has it work, written down on its way to the driver.
#include <epoxy/gl.h>

#include <algorithm>
#include <initializer_list>
#include <string_view>
#include <type_traits>
#include <vector>

namespace equistream::test {

/// One at a time; calls are recorded while it lives.
class RecordedCalls {
public:
    RecordedCalls() {
        calls.clear();
        hook_all(true);
    }
    ~RecordedCalls() { hook_all(false); }
    RecordedCalls(const RecordedCalls&) = delete;
    RecordedCalls& operator=(const RecordedCalls&) = delete;

    /// Names of what was called, in its order.
    const std::vector<std::string_view>& all() const { return calls; }
    std::ptrdiff_t count(std::initializer_list<std::string_view> prefixes) const {
        return std::ranges::count_if(calls, [&](std::string_view call) {
            return std::ranges::any_of(prefixes, [&](std::string_view prefix) { return call.starts_with(prefix); });
        });
    }
    /// Objects, storage, shaders.
    std::ptrdiff_t made() const {
        return count({"glCreate", "glGen", "glCompile", "glLink", "glTextureStorage", "glNamedBufferStorage"});
    }
    std::ptrdiff_t draws() const { return count({"glDraw", "glMultiDraw"}); }
    std::ptrdiff_t dispatches() const { return count({"glDispatch"}); }
    void forget() { calls.clear(); }

private:
    static inline std::vector<std::string_view> calls;

    /// libepoxy's pointers look their functions up when they are called first, and overwrite themselves.
    template <auto& slot, typename Function>
    struct Hook;
    template <auto& slot, typename Result, typename... Values>
    struct Hook<slot, Result (*)(Values...)> {
        static inline Result (*original)(Values...) = nullptr;
        static inline std::string_view name;

        static Result stub(Values... values) {
            calls.push_back(name);
            slot = original;  // which may overwrite it
            struct Again {
                ~Again() {
                    original = slot;
                    slot = stub;
                }
            } again;
            return original(values...);
        }
        static void set(std::string_view called, bool on) {
            if (on) {
                name = called;
                original = slot;
                slot = stub;
            } else {
                slot = original;
            }
        }
    };
    template <auto& slot>
    static void hook(std::string_view name, bool on) {
        Hook<slot, std::remove_reference_t<decltype(slot)>>::set(name, on);
    }

    static void hook_all(bool on) {
#define EQUISTREAM_HOOK(name) hook<epoxy_##name>(#name, on)
        EQUISTREAM_HOOK(glCreateTextures);
        EQUISTREAM_HOOK(glCreateBuffers);
        EQUISTREAM_HOOK(glCreateFramebuffers);
        EQUISTREAM_HOOK(glCreateVertexArrays);
        EQUISTREAM_HOOK(glCreateSamplers);
        EQUISTREAM_HOOK(glCreateQueries);
        EQUISTREAM_HOOK(glCreateProgram);
        EQUISTREAM_HOOK(glCreateShader);
        EQUISTREAM_HOOK(glCompileShader);
        EQUISTREAM_HOOK(glLinkProgram);
        EQUISTREAM_HOOK(glGenTextures);
        EQUISTREAM_HOOK(glGenBuffers);
        EQUISTREAM_HOOK(glGenFramebuffers);
        EQUISTREAM_HOOK(glTextureStorage1D);
        EQUISTREAM_HOOK(glTextureStorage2D);
        EQUISTREAM_HOOK(glTextureStorage3D);
        EQUISTREAM_HOOK(glNamedBufferStorage);
        EQUISTREAM_HOOK(glDrawArrays);
        EQUISTREAM_HOOK(glDrawArraysInstanced);
        EQUISTREAM_HOOK(glDrawArraysIndirect);
        EQUISTREAM_HOOK(glDrawElements);
        EQUISTREAM_HOOK(glDrawElementsIndirect);
        EQUISTREAM_HOOK(glMultiDrawArraysIndirect);
        EQUISTREAM_HOOK(glMultiDrawElementsIndirect);
        EQUISTREAM_HOOK(glMultiDrawElementsIndirectCountARB);
        EQUISTREAM_HOOK(glDispatchCompute);
        EQUISTREAM_HOOK(glDispatchComputeIndirect);
#undef EQUISTREAM_HOOK
    }
};

}  // namespace equistream::test
