sheen_test(cli SOURCES cli_test.cpp cli_test_render.cpp cli_test_compare.cpp cli_test_files.cpp cli_test_limits.cpp cli_test_bake.cpp cli_test_animate.cpp cli_test_manual.cpp USES sheen_scene sheen_make_scenes nlohmann_json::nlohmann_json OpenEXR::OpenEXR)
target_compile_definitions(cli_test PRIVATE SHEEN_PROGRAM="$<TARGET_FILE:sheen>")
add_dependencies(cli_test sheen)
