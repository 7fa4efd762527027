// OpenGL 4.5 core contexts without a window, by OSMesa: Mesa's software rasteriser in this process,
// no display and no GPU; or by EGL: a GPU device, else Mesa's surfaceless platform.
#pragma once

#include <memory>
#include <string>

namespace sheen::gl {

enum class Backend { kOsmesa, kEgl };

/// OSMesa, unless the build is without it: newer Mesa has none.
#ifdef SHEEN_OSMESA
constexpr Backend kDefaultBackend = Backend::kOsmesa;
#else
constexpr Backend kDefaultBackend = Backend::kEgl;
#endif

/// One context. The only open set of the project: a backend.
class Context {
  public:
    virtual ~Context() = default;
    /// Binds the context to the calling thread; a context is current on one thread at a time.
    virtual void makeCurrent() = 0;
    /// Unbinds it, so that another thread may take it or it may be destroyed.
    virtual void release() = 0;
};

/// Makes a context that shares buffers and textures with `share` (may be null) and makes it
/// current. `threads`: how many the software rasteriser may use; a process's first context decides.
/// Errors of its debug output are kept for checkErrors(). Environment error where the backend
/// cannot give OpenGL 4.5, or is not that of the process's first context: functions are loaded
/// once.
std::unique_ptr<Context> makeContext(Backend backend, Context* share, int threads);

/// Renderer name of the current context.
std::string rendererName();

/// Throws std::logic_error if the debug output of any context has reported an error so far.
void checkErrors();

}  // namespace sheen::gl
