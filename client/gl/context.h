#pragma once
/// OpenGL 4.5 core contexts. One context, one thread at a time. Entry points come from libepoxy, of whatever context is
/// current; include <epoxy/gl.h> to call them.
#include <memory>
#include <string>

namespace equistream::gl {

/// What the driver calls itself.
struct Driver {
    std::string vendor, renderer, version;
    /// Mesa's rasterisers on the CPU: right, not fast.
    bool is_software() const;
};

class Context {
public:
    virtual ~Context() = default;
    virtual void make_current() = 0;
    /// So that another thread can make it current.
    virtual void release() = 0;
    /// Of the context that is current.
    static Driver driver();
};

/// Makes a context current for as long as it lives.
class Current {
public:
    explicit Current(Context& context) : context_(context) { context_.make_current(); }
    ~Current() { context_.release(); }
    Current(const Current&) = delete;
    Current& operator=(const Current&) = delete;

private:
    Context& context_;
};

/// Without a window, by EGL: on the first device that has OpenGL 4.5, hardware first. Current when it returns. Throws
/// InputError in one line where there is none.
std::unique_ptr<Context> make_offscreen_context();

/// For tests: what the driver reports from now on as an error of use, a wrong call of ours, ends the program. Of the
/// current context.
void abort_on_errors();

}  // namespace equistream::gl
