# sheen_library(NAME SOURCES ... USES ...): the library of one folder of src/. Sources are named
# relative to the folder; what it uses is visible to whoever uses it, since headers include headers.
function(sheen_library name)
    cmake_parse_arguments(ARG "" "" "SOURCES;USES" ${ARGN})
    if(ARG_SOURCES)
        add_library(sheen_${name} STATIC ${ARG_SOURCES})
        target_include_directories(sheen_${name} PUBLIC ${PROJECT_SOURCE_DIR}/src
                                                        ${PROJECT_SOURCE_DIR}/shaders)
        target_link_libraries(sheen_${name} PUBLIC ${ARG_USES})
    else()
        add_library(sheen_${name} INTERFACE)
        target_include_directories(sheen_${name} INTERFACE ${PROJECT_SOURCE_DIR}/src
                                                           ${PROJECT_SOURCE_DIR}/shaders)
        target_link_libraries(sheen_${name} INTERFACE ${ARG_USES})
    endif()
endfunction()
