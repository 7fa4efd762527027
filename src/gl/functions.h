// The OpenGL 4.5 functions the project calls, loaded from whichever backend made the context.
// Each GL type `PFNGLXPROC` becomes a function pointer `glX` in namespace sheen::gl.
#pragma once

#include <GL/glcorearb.h>

#define SHEEN_GL_FUNCTIONS(X)                                                      \
    X(PFNGLATTACHSHADERPROC, glAttachShader)                                       \
    X(PFNGLBINDBUFFERBASEPROC, glBindBufferBase)                                   \
    X(PFNGLBINDBUFFERPROC, glBindBuffer)                                           \
    X(PFNGLBINDFRAMEBUFFERPROC, glBindFramebuffer)                                 \
    X(PFNGLBINDIMAGETEXTUREPROC, glBindImageTexture)                               \
    X(PFNGLBINDTEXTUREUNITPROC, glBindTextureUnit)                                 \
    X(PFNGLBINDVERTEXARRAYPROC, glBindVertexArray)                                 \
    X(PFNGLBLENDFUNCPROC, glBlendFunc)                                             \
    X(PFNGLCHECKNAMEDFRAMEBUFFERSTATUSPROC, glCheckNamedFramebufferStatus)         \
    X(PFNGLCLEARNAMEDFRAMEBUFFERFVPROC, glClearNamedFramebufferfv)                 \
    X(PFNGLCLEARNAMEDFRAMEBUFFERUIVPROC, glClearNamedFramebufferuiv)               \
    X(PFNGLCLIPCONTROLPROC, glClipControl)                                         \
    X(PFNGLCOMPILESHADERPROC, glCompileShader)                                     \
    X(PFNGLCREATEBUFFERSPROC, glCreateBuffers)                                     \
    X(PFNGLCREATEFRAMEBUFFERSPROC, glCreateFramebuffers)                           \
    X(PFNGLCREATEPROGRAMPROC, glCreateProgram)                                     \
    X(PFNGLCREATESHADERPROC, glCreateShader)                                       \
    X(PFNGLCREATETEXTURESPROC, glCreateTextures)                                   \
    X(PFNGLCREATEVERTEXARRAYSPROC, glCreateVertexArrays)                           \
    X(PFNGLDEBUGMESSAGECALLBACKPROC, glDebugMessageCallback)                       \
    X(PFNGLDEBUGMESSAGECONTROLPROC, glDebugMessageControl)                         \
    X(PFNGLDELETEBUFFERSPROC, glDeleteBuffers)                                     \
    X(PFNGLDELETEFRAMEBUFFERSPROC, glDeleteFramebuffers)                           \
    X(PFNGLDELETEPROGRAMPROC, glDeleteProgram)                                     \
    X(PFNGLDELETESHADERPROC, glDeleteShader)                                       \
    X(PFNGLDELETETEXTURESPROC, glDeleteTextures)                                   \
    X(PFNGLDELETEVERTEXARRAYSPROC, glDeleteVertexArrays)                           \
    X(PFNGLDEPTHFUNCPROC, glDepthFunc)                                             \
    X(PFNGLDEPTHMASKPROC, glDepthMask)                                             \
    X(PFNGLDISABLEPROC, glDisable)                                                 \
    X(PFNGLDRAWARRAYSINSTANCEDBASEINSTANCEPROC, glDrawArraysInstancedBaseInstance) \
    X(PFNGLDRAWARRAYSPROC, glDrawArrays)                                           \
    X(PFNGLDRAWELEMENTSPROC, glDrawElements)                                       \
    X(PFNGLENABLEPROC, glEnable)                                                   \
    X(PFNGLENABLEVERTEXARRAYATTRIBPROC, glEnableVertexArrayAttrib)                 \
    X(PFNGLFINISHPROC, glFinish)                                                   \
    X(PFNGLGETERRORPROC, glGetError)                                               \
    X(PFNGLGETINTEGERVPROC, glGetIntegerv)                                         \
    X(PFNGLGETNAMEDBUFFERSUBDATAPROC, glGetNamedBufferSubData)                     \
    X(PFNGLGETPROGRAMINFOLOGPROC, glGetProgramInfoLog)                             \
    X(PFNGLGETPROGRAMIVPROC, glGetProgramiv)                                       \
    X(PFNGLGETSHADERINFOLOGPROC, glGetShaderInfoLog)                               \
    X(PFNGLGETSHADERIVPROC, glGetShaderiv)                                         \
    X(PFNGLGETSTRINGPROC, glGetString)                                             \
    X(PFNGLGETUNIFORMLOCATIONPROC, glGetUniformLocation)                           \
    X(PFNGLLINKPROGRAMPROC, glLinkProgram)                                         \
    X(PFNGLNAMEDBUFFERDATAPROC, glNamedBufferData)                                 \
    X(PFNGLNAMEDBUFFERSUBDATAPROC, glNamedBufferSubData)                           \
    X(PFNGLNAMEDFRAMEBUFFERDRAWBUFFERSPROC, glNamedFramebufferDrawBuffers)         \
    X(PFNGLNAMEDFRAMEBUFFERREADBUFFERPROC, glNamedFramebufferReadBuffer)           \
    X(PFNGLNAMEDFRAMEBUFFERTEXTURELAYERPROC, glNamedFramebufferTextureLayer)       \
    X(PFNGLNAMEDFRAMEBUFFERTEXTUREPROC, glNamedFramebufferTexture)                 \
    X(PFNGLPIXELSTOREIPROC, glPixelStorei)                                         \
    X(PFNGLPROGRAMUNIFORM1FPROC, glProgramUniform1f)                               \
    X(PFNGLPROGRAMUNIFORM1IPROC, glProgramUniform1i)                               \
    X(PFNGLPROGRAMUNIFORM2FPROC, glProgramUniform2f)                               \
    X(PFNGLPROGRAMUNIFORM2IPROC, glProgramUniform2i)                               \
    X(PFNGLPROGRAMUNIFORM3FPROC, glProgramUniform3f)                               \
    X(PFNGLPROGRAMUNIFORM4FPROC, glProgramUniform4f)                               \
    X(PFNGLPROGRAMUNIFORM4FVPROC, glProgramUniform4fv)                             \
    X(PFNGLPROGRAMUNIFORMMATRIX3FVPROC, glProgramUniformMatrix3fv)                 \
    X(PFNGLPROGRAMUNIFORMMATRIX4FVPROC, glProgramUniformMatrix4fv)                 \
    X(PFNGLREADPIXELSPROC, glReadPixels)                                           \
    X(PFNGLSCISSORPROC, glScissor)                                                 \
    X(PFNGLSHADERSOURCEPROC, glShaderSource)                                       \
    X(PFNGLTEXTUREBUFFERPROC, glTextureBuffer)                                     \
    X(PFNGLTEXTUREPARAMETERIPROC, glTextureParameteri)                             \
    X(PFNGLTEXTURESTORAGE2DPROC, glTextureStorage2D)                               \
    X(PFNGLTEXTURESTORAGE3DPROC, glTextureStorage3D)                               \
    X(PFNGLTEXTURESUBIMAGE2DPROC, glTextureSubImage2D)                             \
    X(PFNGLUSEPROGRAMPROC, glUseProgram)                                           \
    X(PFNGLVERTEXARRAYATTRIBBINDINGPROC, glVertexArrayAttribBinding)               \
    X(PFNGLVERTEXARRAYATTRIBFORMATPROC, glVertexArrayAttribFormat)                 \
    X(PFNGLVERTEXARRAYELEMENTBUFFERPROC, glVertexArrayElementBuffer)               \
    X(PFNGLVERTEXARRAYVERTEXBUFFERPROC, glVertexArrayVertexBuffer)                 \
    X(PFNGLVIEWPORTPROC, glViewport)

namespace sheen::gl {

#define SHEEN_GL_DECLARE(type, name) extern type name;
SHEEN_GL_FUNCTIONS(SHEEN_GL_DECLARE)
#undef SHEEN_GL_DECLARE

/// Loads every function through `get_address`; environment error naming the first one missing.
/// Thread-safe: a process uses one backend, so the pointers are loaded once.
void loadFunctions(void* (*get_address)(const char* name));

}  // namespace sheen::gl
