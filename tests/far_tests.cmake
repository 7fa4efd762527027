sheen_test(far SOURCES far_test.cpp case_scenes.cpp
           USES sheen_render sheen_metrics sheen_make_scenes)
