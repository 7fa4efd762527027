// A shader whose included file is wrong.
#include "shared/language.glsl"
#include "test/broken.glsl"
#include "shared/language.glsl"
void main() {
}
