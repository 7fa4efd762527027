// Makes one text compile as GLSL and, through GLM, as C++ (included inside namespace
// sheen::shared, which says `using namespace glm`). Rules for files that include this one: float
// literals carry an f, no swizzles, no array constructors, arrays returned only inside structs.
#ifndef SHARED_LANGUAGE_GLSL
#define SHARED_LANGUAGE_GLSL

#ifdef __cplusplus
#define FN inline
#define IN(T) const T&
#define INOUT(T) T&
#else
#define FN
#define IN(T) in T
#define INOUT(T) inout T
#endif

const float PI = 3.14159265358979323846f;

#endif
