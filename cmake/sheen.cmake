# sheen_include_root(TARGET SCOPE NAME): lets a target include the headers of the folder src/NAME, as
# "NAME/file.h", and those of no other: the root holds nothing but a link to that folder.
function(sheen_include_root target scope name)
    set(root ${PROJECT_BINARY_DIR}/include/${name})
    file(MAKE_DIRECTORY ${root})
    file(RELATIVE_PATH folder ${root} ${PROJECT_SOURCE_DIR}/src/${name})
    file(CREATE_LINK ${folder} ${root}/${name} SYMBOLIC)
    target_include_directories(${target} ${scope} ${root})
endfunction()

# sheen_library(NAME SOURCES ... USES ...): the library of one folder of src/. Sources are named
# relative to the folder; what it uses is visible to whoever uses it, since headers include headers.
# It sees the headers of the libraries that it uses, directly or through others, and no others; and
# it may use only those that were added before it. Its sources are one unit to the compiler: headers
# take longer to compile than most files.
function(sheen_library name)
    cmake_parse_arguments(ARG "" "" "SOURCES;USES" ${ARGN})
    foreach(used ${ARG_USES})
        if(used MATCHES "^sheen_" AND NOT TARGET ${used})
            message(FATAL_ERROR "src/${name} may not use ${used}, which CMakeLists.txt adds below it")
        endif()
    endforeach()
    add_library(sheen_${name} STATIC ${ARG_SOURCES})
    set_target_properties(sheen_${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)
    # GCC takes types of a unit's files for a header's.
    target_compile_options(sheen_${name} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
    sheen_include_root(sheen_${name} PUBLIC ${name})
    target_include_directories(sheen_${name} PUBLIC ${PROJECT_SOURCE_DIR}/shaders)
    target_link_libraries(sheen_${name} PUBLIC ${ARG_USES})
endfunction()
