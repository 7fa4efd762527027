#include "gl/objects.h"

#include <vector>

#include "core/error.h"
#include "gl/context.h"

namespace sheen::gl {
namespace {

Texture makeTexture(GLenum target) {
    GLuint name = 0;
    glCreateTextures(target, 1, &name);
    glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTextureParameteri(name, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(name, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    return Texture(name);
}

}  // namespace

Texture makeTexture2d(GLenum format, int width, int height) {
    Texture texture = makeTexture(GL_TEXTURE_2D);
    glTextureStorage2D(texture.name(), 1, format, width, height);
    return texture;
}

Texture makeTexture2dArray(GLenum format, int width, int height, int layers) {
    Texture texture = makeTexture(GL_TEXTURE_2D_ARRAY);
    glTextureStorage3D(texture.name(), 1, format, width, height, layers);
    return texture;
}

Texture makeBufferTexture(GLenum format, const Buffer& buffer) {
    GLuint name = 0;
    glCreateTextures(GL_TEXTURE_BUFFER, 1, &name);
    glTextureBuffer(name, format, buffer.name());
    return Texture(name);
}

Framebuffer makeFramebuffer(std::span<const GLuint> colors, GLuint depth) {
    GLuint name = 0;
    glCreateFramebuffers(1, &name);
    Framebuffer framebuffer(name);
    std::vector<GLenum> attachments;
    for (GLuint color : colors) {
        const GLenum attachment = GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(attachments.size());
        glNamedFramebufferTexture(name, attachment, color, 0);
        attachments.push_back(attachment);
    }
    if (depth != 0) {
        glNamedFramebufferTexture(name, GL_DEPTH_ATTACHMENT, depth, 0);
    }
    glNamedFramebufferDrawBuffers(name, static_cast<GLsizei>(attachments.size()),
                                  attachments.data());
    checkErrors();  // a texture that there was no memory for
    SHEEN_CHECK_EQ(glCheckNamedFramebufferStatus(name, GL_FRAMEBUFFER),
                   static_cast<GLenum>(GL_FRAMEBUFFER_COMPLETE));
    return framebuffer;
}

VertexArray makeVertexArray() {
    GLuint name = 0;
    glCreateVertexArrays(1, &name);
    return VertexArray(name);
}

}  // namespace sheen::gl
