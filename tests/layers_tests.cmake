# Each library sees the headers of those it uses and no others (cmake/sheen.cmake): a file with an
# #include that leads upward does not compile, and for that reason.
add_library(upward_include OBJECT EXCLUDE_FROM_ALL upward_include.cpp)
target_link_libraries(upward_include PRIVATE sheen_cache)
add_test(NAME Layers.anUpwardIncludeDoesNotCompile
         COMMAND ${CMAKE_CXX_COMPILER} -std=c++20 -fsyntax-only
                 "-I$<JOIN:$<TARGET_PROPERTY:upward_include,INCLUDE_DIRECTORIES>,;-I>"
                 ${CMAKE_CURRENT_SOURCE_DIR}/upward_include.cpp
         COMMAND_EXPAND_LISTS)
set_tests_properties(
    Layers.anUpwardIncludeDoesNotCompile
    PROPERTIES PASS_REGULAR_EXPRESSION "render/render.h: No such file|'render/render.h' file not found")
