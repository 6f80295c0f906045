#pragma once
/// OpenGL 4.5 core contexts. One context, one thread at a time. Entry points come from libepoxy, of whatever context is
/// current; include <epoxy/gl.h> to call them.
#include <memory>
#include <string>

namespace equistream::gl {

/// What the driver calls itself.
struct Driver {
    std::string vendor, renderer, version;

    /// Whether it draws on the CPU (Mesa's llvmpipe and softpipe), where shaders cost what loops of C++ do not.
    bool is_software() const;
};

class Context {
public:
    virtual ~Context() = default;
    /// Throws WorkError where the driver does not let it.
    virtual void make_current() = 0;
    /// So that another thread can make it current.
    virtual void release() = 0;
    /// Of the context that is current.
    static Driver driver();
};

/// Remembers which of EGL's contexts is current in this thread, if any, and makes it so again when it goes.
class KeptContext {
public:
    KeptContext();
    ~KeptContext();
    KeptContext(const KeptContext&) = delete;
    KeptContext& operator=(const KeptContext&) = delete;

private:
    void *display_, *context_, *draw_, *read_;
};

/// Makes a context current for as long as it lives; then the one that was before is again.
class Current {
public:
    explicit Current(Context& context) { context.make_current(); }

private:
    KeptContext before_;
};

/// Without a window, by EGL: on the first device that has OpenGL 4.5 with GL_ARB_shader_viewport_layer_array and
/// GL_ARB_indirect_parameters, hardware first. Current when it returns. Throws InputError in one line, of what is
/// missing, where there is none.
std::unique_ptr<Context> make_offscreen_context();

/// What the current context lacks of that; empty where it has all.
std::string missing_requirement();

/// For tests: in contexts that are made from now on, what the driver reports as an error of use, a wrong call of ours,
/// ends the program.
void abort_on_errors();

}  // namespace equistream::gl
