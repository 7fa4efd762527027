# Writes every file under SHADERS (a ;-list, relative to ROOT) into OUTPUT as C++ string literals.
set(text "#include <string_view>\nnamespace sheen::gl {\nstruct EmbeddedShader { std::string_view path; std::string_view text; };\nextern const EmbeddedShader kEmbeddedShaders[];\nextern const int kEmbeddedShaderCount;\nconst EmbeddedShader kEmbeddedShaders[] = {\n")
foreach(file ${SHADERS})
    file(READ ${ROOT}/${file} content)
    string(APPEND text "{\"${file}\", R\"__glsl__(${content})__glsl__\"},\n")
endforeach()
list(LENGTH SHADERS count)
string(APPEND text "};\nconst int kEmbeddedShaderCount = ${count};\n}\n")
file(WRITE ${OUTPUT} "${text}")
