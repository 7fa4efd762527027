sheen_test(accuracy SOURCES accuracy_test.cpp accuracy_test_hints.cpp case_scenes.cpp
           USES sheen_render sheen_metrics sheen_make_scenes)
target_compile_definitions(accuracy_test PRIVATE
                           SHEEN_REFERENCES="${CMAKE_CURRENT_SOURCE_DIR}/references")

# tests/references/make calls it.
add_executable(make_accuracy_reference make_accuracy_reference.cpp case_scenes.cpp)
target_link_libraries(make_accuracy_reference PRIVATE sheen_image sheen_make_scenes OpenEXR::OpenEXR)
