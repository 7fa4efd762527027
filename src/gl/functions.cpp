#include "gl/functions.h"

#include <mutex>

#include "core/error.h"

namespace sheen::gl {

#define SHEEN_GL_DEFINE(type, name) type name = nullptr;
SHEEN_GL_FUNCTIONS(SHEEN_GL_DEFINE)
#undef SHEEN_GL_DEFINE

void loadFunctions(void* (*get_address)(const char* name)) {
    static std::once_flag once;
    std::call_once(once, [get_address] {
#define SHEEN_GL_LOAD(type, name)                                                      \
    name = reinterpret_cast<type>(get_address(#name));                                 \
    if (name == nullptr) {                                                             \
        throwEnvironment("OpenGL: the driver has no {}; OpenGL 4.5 is needed", #name); \
    }
        SHEEN_GL_FUNCTIONS(SHEEN_GL_LOAD)
#undef SHEEN_GL_LOAD
    });
}

}  // namespace sheen::gl
