sheen_test(bake SOURCES bake_test.cpp bake_test_atlas.cpp bake_test_buried.cpp bake_test_file.cpp bake_test_shown.cpp bake_test_probes.cpp
                        bake_test_directional.cpp
           USES sheen_bake sheen_metrics sheen_make_scenes nlohmann_json::nlohmann_json)
