#include "test/no_such_file.glsl"
void main() {
}
