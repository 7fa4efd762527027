#include "gl/context.h"

// The core profile's declarations come before osmesa.h, which includes the legacy <GL/gl.h>: that
// header would otherwise hide the function types of OpenGL 1.0 to 1.3.
// clang-format off
#include "gl/functions.h"
#include <EGL/egl.h>
#include <EGL/eglext.h>
#ifdef SHEEN_OSMESA
#include <GL/osmesa.h>
#endif
// clang-format on

#include <cstdlib>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <vector>

#include "core/error.h"

namespace sheen::gl {
namespace {

std::mutex g_error_mutex;
std::string g_first_error;

void APIENTRY onDebugMessage(GLenum, GLenum type, GLuint, GLenum, GLsizei, const GLchar* message,
                             const void*) {
    if (type == GL_DEBUG_TYPE_ERROR) {
        const std::lock_guard<std::mutex> lock(g_error_mutex);
        if (g_first_error.empty()) {
            g_first_error = message;
        }
    }
}

// State every context starts with: reversed depth (near = 1, far = 0) needs a [0, 1] clip range.
void initialise() {
    glEnable(GL_DEBUG_OUTPUT);
    glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    glDebugMessageCallback(onDebugMessage, nullptr);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glDepthFunc(GL_GREATER);
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
}

#ifdef SHEEN_OSMESA
class OsmesaContext : public Context {
  public:
    OsmesaContext(OSMesaContext share, int threads) {
        // Mesa reads this when the process makes its first context. One lock of the rasteriser
        // lets only one context shade at a time, so shading gets its parallelism from the
        // rasteriser's own threads (by tiles of 64 x 64 pixels), and everything before and after
        // it from several contexts.
        setenv("LP_NUM_THREADS", std::to_string(threads > 1 ? threads : 0).c_str(), 1);
        const int attributes[] = {OSMESA_FORMAT,
                                  OSMESA_RGBA,
                                  OSMESA_PROFILE,
                                  OSMESA_CORE_PROFILE,
                                  OSMESA_CONTEXT_MAJOR_VERSION,
                                  4,
                                  OSMESA_CONTEXT_MINOR_VERSION,
                                  5,
                                  0};
        context_ = OSMesaCreateContextAttribs(attributes, share);
        if (context_ == nullptr) {
            throwEnvironment("OpenGL: OSMesa cannot make an OpenGL 4.5 core context");
        }
    }
    ~OsmesaContext() override { OSMesaDestroyContext(context_); }
    void makeCurrent() override {
        if (OSMesaMakeCurrent(context_, &pixel_, GL_UNSIGNED_BYTE, 1, 1) == 0) {
            throwEnvironment("OpenGL: OSMesaMakeCurrent failed");
        }
    }
    void release() override { OSMesaMakeCurrent(nullptr, nullptr, 0, 0, 0); }
    OSMesaContext handle() const { return context_; }

  private:
    OSMesaContext context_ = nullptr;
    uint32_t pixel_ = 0;  // OSMesa wants a default framebuffer; nothing is drawn into it
};

std::unique_ptr<Context> makeOsmesaContext(Context* share, int threads) {
    auto* other = dynamic_cast<OsmesaContext*>(share);
    auto context =
        std::make_unique<OsmesaContext>(other != nullptr ? other->handle() : nullptr, threads);
    context->makeCurrent();
    loadFunctions(
        [](const char* name) { return reinterpret_cast<void*>(OSMesaGetProcAddress(name)); });
    return context;
}
#else
std::unique_ptr<Context> makeOsmesaContext(Context*, int) {
    throwEnvironment("OpenGL: this build is without OSMesa; use --gl egl");
}
#endif

// The EGL display without a window system: the first GPU device, else Mesa's surfaceless platform.
EGLDisplay openDisplay() {
    const auto get_platform_display = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(
        eglGetProcAddress("eglGetPlatformDisplayEXT"));
    const auto query_devices =
        reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(eglGetProcAddress("eglQueryDevicesEXT"));
    std::vector<EGLDisplay> candidates;
    if (get_platform_display != nullptr && query_devices != nullptr) {
        EGLDeviceEXT devices[16];
        EGLint count = 0;
        if (query_devices(16, devices, &count) != 0) {
            for (EGLint i = 0; i < count; ++i) {
                candidates.push_back(
                    get_platform_display(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr));
            }
        }
    }
    if (get_platform_display != nullptr) {
        candidates.push_back(get_platform_display(
            EGL_PLATFORM_SURFACELESS_MESA, reinterpret_cast<void*>(EGL_DEFAULT_DISPLAY), nullptr));
    }
    for (EGLDisplay display : candidates) {
        EGLint major = 0;
        EGLint minor = 0;
        if (display != EGL_NO_DISPLAY && eglInitialize(display, &major, &minor) != 0) {
            return display;
        }
    }
    throwEnvironment("OpenGL: EGL finds no display; --gl osmesa needs none");
}

class EglContext : public Context {
  public:
    explicit EglContext(EGLContext share) {
        static const EGLDisplay display = openDisplay();
        display_ = display;
        eglBindAPI(EGL_OPENGL_API);
        const EGLint config_attributes[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE,
                                            EGL_DONT_CARE, EGL_NONE};
        EGLConfig config = nullptr;
        EGLint count = 0;
        eglChooseConfig(display_, config_attributes, &config, 1, &count);
        const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                     4,
                                     EGL_CONTEXT_MINOR_VERSION,
                                     5,
                                     EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                     EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                     EGL_NONE};
        context_ =
            count > 0 ? eglCreateContext(display_, config, share, attributes) : EGL_NO_CONTEXT;
        if (context_ == EGL_NO_CONTEXT) {
            throwEnvironment("OpenGL: EGL cannot make an OpenGL 4.5 core context (error {:#x})",
                             eglGetError());
        }
    }
    ~EglContext() override { eglDestroyContext(display_, context_); }
    void makeCurrent() override {
        eglBindAPI(EGL_OPENGL_API);
        if (eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == 0) {
            throwEnvironment("OpenGL: eglMakeCurrent failed (error {:#x})", eglGetError());
        }
    }
    void release() override {
        eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    }
    EGLContext handle() const { return context_; }

  private:
    EGLDisplay display_ = EGL_NO_DISPLAY;
    EGLContext context_ = EGL_NO_CONTEXT;
};

std::unique_ptr<Context> makeEglContext(Context* share) {
    auto* other = dynamic_cast<EglContext*>(share);
    auto context =
        std::make_unique<EglContext>(other != nullptr ? other->handle() : EGL_NO_CONTEXT);
    context->makeCurrent();
    loadFunctions(
        [](const char* name) { return reinterpret_cast<void*>(eglGetProcAddress(name)); });
    return context;
}

std::mutex g_backend_mutex;
std::optional<Backend> g_backend;  // of the process's first context

std::unique_ptr<Context> makeContextBy(Backend backend, Context* share, int threads) {
    const std::lock_guard<std::mutex> lock(g_backend_mutex);
    if (g_backend && *g_backend != backend) {
        throwEnvironment("OpenGL: this process has used its other backend before; start it anew");
    }
    auto context =
        backend == Backend::kOsmesa ? makeOsmesaContext(share, threads) : makeEglContext(share);
    g_backend = backend;
    return context;
}

}  // namespace

std::unique_ptr<Context> makeContext(Backend backend, Context* share, int threads) {
    std::unique_ptr<Context> context = makeContextBy(backend, share, threads);
    initialise();
    return context;
}

std::string rendererName() { return reinterpret_cast<const char*>(glGetString(GL_RENDERER)); }

void checkErrors() {
    const std::lock_guard<std::mutex> lock(g_error_mutex);
    if (!g_first_error.empty()) {
        if (g_first_error.find("OUT_OF_MEMORY") != std::string::npos) {
            throwEnvironment("OpenGL: {}: render a smaller image", oneLine(g_first_error));
        }
        throw std::logic_error("OpenGL: " + g_first_error);
    }
}

}  // namespace sheen::gl
