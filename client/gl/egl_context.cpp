#include "context.h"

#include <equistream/error.h>

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <array>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

namespace equistream::gl {

namespace {

constexpr EGLint most_devices = 16;

/// An initialised display; EGL has one of each device for the whole process, which goes with the last context on it.
class Display {
public:
    /// Null where it cannot be initialised.
    static std::shared_ptr<Display> shared(EGLDisplay handle) {
        static std::map<EGLDisplay, std::weak_ptr<Display>> known;
        const std::lock_guard lock(mutex);
        std::shared_ptr<Display> display = known[handle].lock();
        if (display || eglInitialize(handle, nullptr, nullptr) != EGL_TRUE)
            return display;
        display.reset(new Display(handle));
        known[handle] = display;
        return display;
    }
    ~Display() {
        const std::lock_guard lock(mutex);
        eglTerminate(handle_);
    }
    Display(const Display&) = delete;
    Display& operator=(const Display&) = delete;

    EGLDisplay handle() const { return handle_; }

private:
    explicit Display(EGLDisplay handle) : handle_(handle) {}
    static inline std::mutex mutex;
    EGLDisplay handle_;
};

/// A context without a surface.
class EglContext : public Context {
public:
    EglContext(std::shared_ptr<Display> display, EGLContext context)
        : display_(std::move(display)), context_(context) {}
    ~EglContext() override {
        if (eglGetCurrentContext() == context_)
            EglContext::release();
        eglDestroyContext(display_->handle(), context_);
    }
    EglContext(const EglContext&) = delete;
    EglContext& operator=(const EglContext&) = delete;

    void make_current() override {
        if (eglMakeCurrent(display_->handle(), EGL_NO_SURFACE, EGL_NO_SURFACE, context_) != EGL_TRUE)
            throw WorkError("OpenGL: the context without a window could not be made current");
    }
    void release() override { eglMakeCurrent(display_->handle(), EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT); }

private:
    std::shared_ptr<Display> display_;
    EGLContext context_;
};

/// Nothing where the display has no OpenGL 4.5.
std::unique_ptr<Context> context_on(EGLDisplay handle) {
    const std::shared_ptr<Display> display = handle == EGL_NO_DISPLAY ? nullptr : Display::shared(handle);
    if (!display)
        return nullptr;
    constexpr std::array<EGLint, 7> wanted = {
        EGL_CONTEXT_MAJOR_VERSION,           4,       EGL_CONTEXT_MINOR_VERSION, 5, EGL_CONTEXT_OPENGL_PROFILE_MASK,
        EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
    EGLContext context = EGL_NO_CONTEXT;
    if (eglBindAPI(EGL_OPENGL_API) == EGL_TRUE)
        context = eglCreateContext(handle, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, wanted.data());
    return context == EGL_NO_CONTEXT ? nullptr : std::make_unique<EglContext>(display, context);
}

bool client_has(const char* extension) {
    return epoxy_has_egl_extension(EGL_NO_DISPLAY, extension);
}

/// Every device of the machine, hardware before software, then Mesa without any.
std::vector<EGLDisplay> displays() {
    std::vector<EGLDisplay> all;
    if (!client_has("EGL_EXT_platform_base"))
        return {eglGetDisplay(EGL_DEFAULT_DISPLAY)};
    if (client_has("EGL_EXT_device_enumeration") && client_has("EGL_EXT_device_query") &&
        client_has("EGL_EXT_platform_device")) {
        std::array<EGLDeviceEXT, most_devices> devices{};
        EGLint count = 0;
        if (eglQueryDevicesEXT(most_devices, devices.data(), &count) != EGL_TRUE)
            count = 0;
        for (const bool software : {false, true})
            for (EGLint i = 0; i < count; ++i) {
                const char* extensions = eglQueryDeviceStringEXT(devices[std::size_t(i)], EGL_EXTENSIONS);
                const bool is_software = extensions != nullptr &&
                                         std::string(extensions).find("EGL_MESA_device_software") != std::string::npos;
                if (is_software == software)
                    all.push_back(eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[std::size_t(i)], nullptr));
            }
    }
    if (client_has("EGL_MESA_platform_surfaceless"))
        all.push_back(eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr));
    return all;
}

}  // namespace

std::unique_ptr<Context> make_offscreen_context() {
    for (const EGLDisplay display : displays())
        if (auto context = context_on(display)) {
            context->make_current();
            return context;
        }
    throw InputError(expected_found("OpenGL", "a driver with version 4.5 that EGL can use without a window",
                                    "none (Mesa's, on the CPU, is in the package libgl1-mesa-dri)"));
}

}  // namespace equistream::gl
