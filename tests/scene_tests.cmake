sheen_test(scene SOURCES scene_test.cpp scene_test_malformed.cpp scene_test_shading.cpp
                         scene_test_environment.cpp scene_test_sky.cpp scene_test_files.cpp scene_test_moved.cpp
                         scene_test_values.cpp scene_test_textures.cpp scene_test_levels.cpp scene_test_coverage.cpp
                         scene_test_normal_maps.cpp scene_test_optional.cpp scene_test_extensions.cpp scene_test_draco.cpp
                         scene_test_animation.cpp scene_test_keyframes.cpp scene_test_film.cpp
           USES sheen_scene sheen_reference sheen_make_scenes nlohmann_json::nlohmann_json meshoptimizer::meshoptimizer draco_after_tinygltf
                PkgConfig::WEBP)
