#include "context.h"
#include "errors.h"
#include "requirements.h"

#include <equistream/error.h>

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <array>
#include <string>
#include <vector>

namespace equistream::gl {

namespace {

constexpr EGLint max_devices = 16;

/// A context without a surface. Its display stays initialised: EGL has one of each device for the whole process, which
/// others may use.
class EglContext : public Context {
public:
    EglContext(EGLDisplay display, EGLContext context) : display_(display), context_(context) {}
    ~EglContext() override {
        if (eglGetCurrentContext() == context_)
            EglContext::release();
        eglDestroyContext(display_, context_);
    }
    EglContext(const EglContext&) = delete;
    EglContext& operator=(const EglContext&) = delete;

    void make_current() override {
        if (eglBindAPI(EGL_OPENGL_API) != EGL_TRUE ||
            eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) != EGL_TRUE)
            throw WorkError("OpenGL: the context without a window could not be made current");
    }
    void release() override { eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT); }

private:
    EGLDisplay display_;
    EGLContext context_;
};

/// Nothing where the display has no OpenGL 4.5.
std::unique_ptr<Context> context_on(EGLDisplay display) {
    if (display == EGL_NO_DISPLAY || eglInitialize(display, nullptr, nullptr) != EGL_TRUE)
        return nullptr;
    const std::array<EGLint, 9> wanted = {EGL_CONTEXT_MAJOR_VERSION,
                                          4,
                                          EGL_CONTEXT_MINOR_VERSION,
                                          5,
                                          EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                          EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                          EGL_CONTEXT_OPENGL_DEBUG,
                                          errors_abort() ? EGL_TRUE : EGL_FALSE,
                                          EGL_NONE};
    EGLContext context = EGL_NO_CONTEXT;
    if (eglBindAPI(EGL_OPENGL_API) == EGL_TRUE)
        context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, wanted.data());
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
        std::array<EGLDeviceEXT, max_devices> devices{};
        EGLint count = 0;
        if (eglQueryDevicesEXT(max_devices, devices.data(), &count) != EGL_TRUE)
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

KeptContext::KeptContext()
    : display_(eglGetCurrentDisplay()), context_(eglGetCurrentContext()), draw_(eglGetCurrentSurface(EGL_DRAW)),
      read_(eglGetCurrentSurface(EGL_READ)) {}

KeptContext::~KeptContext() {
    if (context_ != EGL_NO_CONTEXT)
        eglMakeCurrent(display_, draw_, read_, context_);
    else if (eglGetCurrentContext() != EGL_NO_CONTEXT)
        eglMakeCurrent(eglGetCurrentDisplay(), EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
}

std::unique_ptr<Context> make_offscreen_context() {
    std::string found;
    const auto pass_over = [&](const std::string& why) { found += (found.empty() ? "" : ", ") + why; };
    for (const EGLDisplay display : displays()) {
        std::unique_ptr<Context> context = context_on(display);
        if (!context)
            continue;
        try {
            context->make_current();
        } catch (const WorkError&) {
            pass_over("one that cannot be made current");
            continue;
        }
        const std::string lack = missing_requirement();
        if (lack.empty()) {
            if (errors_abort())
                watch_errors();
            return context;
        }
        pass_over(Context::driver().renderer + " without " + lack);
    }
    throw InputError(expected_found(
        "OpenGL",
        "a driver that EGL can use without a window, with version 4.5, GL_ARB_shader_viewport_layer_array and "
        "GL_ARB_indirect_parameters",
        found.empty() ? "none (Mesa's, on the CPU, is in the package libgl1-mesa-dri)" : found));
}

}  // namespace equistream::gl
