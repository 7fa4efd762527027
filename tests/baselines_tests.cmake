sheen_test(baselines SOURCES baselines_test.cpp baselines_test_cache.cpp baselines_test_denoise.cpp
           USES sheen_baselines sheen_metrics)
