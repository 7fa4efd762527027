// Move-only owners of OpenGL objects. A default-constructed one owns nothing.
#pragma once

#include <span>
#include <utility>

#include "gl/functions.h"

namespace sheen::gl {

/// Owner of one object name; `Delete` frees it on the context that is current then.
template <void (*Delete)(GLuint)>
class Object {
  public:
    Object() = default;
    explicit Object(GLuint name) : name_(name) {}
    Object(Object&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
    Object& operator=(Object&& other) noexcept {
        std::swap(name_, other.name_);
        return *this;
    }
    ~Object() {
        if (name_ != 0) {
            Delete(name_);
        }
    }
    GLuint name() const { return name_; }

  private:
    GLuint name_ = 0;
};

inline void deleteBuffer(GLuint name) { glDeleteBuffers(1, &name); }
inline void deleteTexture(GLuint name) { glDeleteTextures(1, &name); }
inline void deleteFramebuffer(GLuint name) { glDeleteFramebuffers(1, &name); }
inline void deleteVertexArray(GLuint name) { glDeleteVertexArrays(1, &name); }
inline void deleteProgram(GLuint name) { glDeleteProgram(name); }
inline void deleteShader(GLuint name) { glDeleteShader(name); }

using Buffer = Object<deleteBuffer>;
using Texture = Object<deleteTexture>;
using Framebuffer = Object<deleteFramebuffer>;
using VertexArray = Object<deleteVertexArray>;
using ProgramObject = Object<deleteProgram>;
using Shader = Object<deleteShader>;

/// A buffer holding a copy of `data`; an empty one still has a byte, so that it can be bound.
template <class T>
Buffer makeBuffer(std::span<const T> data) {
    GLuint name = 0;
    glCreateBuffers(1, &name);
    glNamedBufferData(name, data.empty() ? 16 : static_cast<GLsizeiptr>(data.size_bytes()),
                      data.empty() ? nullptr : data.data(), GL_STATIC_DRAW);
    return Buffer(name);
}

/// Replaces the contents of `buffer`, whatever its size was.
template <class T>
void refillBuffer(const Buffer& buffer, std::span<const T> data) {
    glNamedBufferData(buffer.name(), static_cast<GLsizeiptr>(data.size_bytes()), data.data(),
                      GL_STREAM_DRAW);
}

/// A 2D texture without mipmaps, nearest filtering, clamped.
Texture makeTexture2d(GLenum format, int width, int height);
/// The same with layers.
Texture makeTexture2dArray(GLenum format, int width, int height, int layers);

/// What a buffer holds, as a texture of one row of texels.
Texture makeBufferTexture(GLenum format, const Buffer& buffer);

/// A framebuffer of colour attachments 0.. and an optional depth attachment (0: none).
/// Checked complete.
Framebuffer makeFramebuffer(std::span<const GLuint> colors, GLuint depth);

/// An empty vertex array, for passes whose vertex shader needs none.
VertexArray makeVertexArray();

}  // namespace sheen::gl
