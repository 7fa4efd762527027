// Shader programs from the sources embedded in the library (everything under shaders/).
#pragma once

#include <initializer_list>
#include <string>
#include <vector>

#include "core/math.h"
#include "gl/objects.h"

namespace sheen::gl {

/// The text of an embedded shader file with its `#include "..."` lines resolved, each file once,
/// and `#line` marks so that errors can be traced: source string numbers index `files`.
struct ShaderSource {
    std::string text;
    std::vector<std::string> files;
};
ShaderSource expandIncludes(const std::string& path);

/// A linked vertex + fragment program. Uniforms are set by name; one the compiler removed is
/// ignored.
class Program {
  public:
    Program() = default;
    /// Paths as under shaders/, e.g. "raster/visibility.vert"; each define is "NAME value".
    /// Throws std::logic_error with the compiler's log: our shaders compile, or it is a bug.
    Program(const std::string& vertex, const std::string& fragment,
            const std::vector<std::string>& defines = {});

    GLuint name() const { return program_.name(); }
    void use() const { glUseProgram(program_.name()); }
    void set(const char* uniform, float value) const;
    void set(const char* uniform, int value) const;
    void set(const char* uniform, const vec2& value) const;
    void set(const char* uniform, const glm::ivec2& value) const;
    void set(const char* uniform, const vec3& value) const;
    void set(const char* uniform, const vec4& value) const;
    void set(const char* uniform, const mat4& value) const;
    /// Where a uniform is, -1 for one the compiler removed; for what is set with every draw.
    GLint location(const char* uniform) const {
        return glGetUniformLocation(program_.name(), uniform);
    }

  private:
    ProgramObject program_;
};

/// Draws one triangle that covers the viewport, with a vertex array bound.
inline void drawFullscreen() { glDrawArrays(GL_TRIANGLES, 0, 3); }

}  // namespace sheen::gl
