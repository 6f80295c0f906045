#include "context.h"

#include <equistream/error.h>

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <array>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace equistream::gl {

namespace {

constexpr EGLint max_devices = 16;

/// Whether contexts that are made now shall be debug contexts and be watched.
std::atomic<bool> errors_abort = false;

void GLAPIENTRY on_message(GLenum source, GLenum type, GLuint, GLenum, GLsizei, const GLchar* message, const void*) {
    // Programs throw what their compiler says.
    if (source == GL_DEBUG_SOURCE_SHADER_COMPILER || type != GL_DEBUG_TYPE_ERROR)
        return;
    std::fprintf(stderr, "OpenGL: %s\n", message);
    std::abort();
}

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
                                          errors_abort ? EGL_TRUE : EGL_FALSE,
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

void abort_on_errors() {
    errors_abort = true;
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

std::string missing_requirement() {
    constexpr int min_version = 45;
    if (epoxy_gl_version() < min_version)
        return "version 4.5";
    for (const char* extension : {"GL_ARB_shader_viewport_layer_array", "GL_ARB_indirect_parameters"})
        if (!epoxy_has_gl_extension(extension))
            return extension;
    return "";
}

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
            if (errors_abort) {
                glEnable(GL_DEBUG_OUTPUT);
                glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
                glDebugMessageCallback(on_message, nullptr);
            }
            return context;
        }
        pass_over(Context::driver().renderer + " without " + lack);
    }
    throw InputError(expected_found(
        "OpenGL",
        "a driver that EGL can use without a window, with version 4.5, GL_ARB_shader_viewport_layer_array and "
        "GL_ARB_indirect_parameters",
        found.empty() ? "none (install the GPU's driver, or libgl1-mesa-dri, which draws on the CPU)" : found));
}

}  // namespace equistream::gl
