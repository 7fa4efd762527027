# The library as others see it: by its header alone, through the shared object.
sheen_test(library SOURCES library_test.cpp library_test_arrays.cpp library_test_listener.cpp library_test_points.cpp
           USES Sheen::sheen)
target_compile_definitions(library_test PRIVATE SHEEN_PROGRAM="$<TARGET_FILE:sheen>")
add_dependencies(library_test sheen)
add_test(NAME Library.ShowsTheSymbolsOfItsList
         COMMAND ${CMAKE_COMMAND} -DNM=${CMAKE_NM} -DLIBRARY=$<TARGET_FILE:libsheen>
                 -DLIST=${CMAKE_CURRENT_SOURCE_DIR}/library_symbols.txt -P
                 ${CMAKE_CURRENT_SOURCE_DIR}/library_symbols.cmake)
add_test(NAME Library.HeaderIsC
         COMMAND ${CMAKE_C_COMPILER} -std=c99 -pedantic -Wall -Wextra -Werror -fsyntax-only -x c
                 ${PROJECT_SOURCE_DIR}/include/sheen/sheen_c.h)
add_test(NAME Library.HeaderIsCxx17
         COMMAND ${CMAKE_CXX_COMPILER} -std=c++17 -pedantic -Wall -Wextra -Werror -fsyntax-only
                 -I${PROJECT_SOURCE_DIR}/include ${PROJECT_SOURCE_DIR}/examples/image.cpp)
add_test(NAME Library.ExampleInCRenders
         COMMAND image_c ${PROJECT_SOURCE_DIR}/scenes/cornell_diffuse.glb
                 ${CMAKE_CURRENT_BINARY_DIR}/image_c.exr)
add_test(NAME Library.ExampleAsksPoints
         COMMAND points ${PROJECT_SOURCE_DIR}/scenes/cornell_diffuse.glb)
set_tests_properties(Library.ExampleAsksPoints PROPERTIES PASS_REGULAR_EXPRESSION "lux")
add_test(NAME Library.ExampleRefinesToATarget
         COMMAND progressive ${CMAKE_CURRENT_BINARY_DIR}/progressive.png 0.2 60)
set_tests_properties(Library.ExampleRefinesToATarget PROPERTIES PASS_REGULAR_EXPRESSION
                                                                "error at most 1?[0-9][.][0-9]%")
if(NOT SHEEN_SANITIZE)
    add_test(NAME Package.WorksWhereItIsInstalled
             COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/package_test.sh ${PROJECT_BINARY_DIR}
                     ${Python3_EXECUTABLE})
endif()
if(SHEEN_PYTHON)
    add_test(NAME Python.Module COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/python_test.py
                                        ${PROJECT_SOURCE_DIR}/scenes)
    set_tests_properties(Python.Module PROPERTIES ENVIRONMENT
                                                  "PYTHONPATH=$<TARGET_FILE_DIR:sheen_python>")
endif()
