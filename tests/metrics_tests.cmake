sheen_test(metrics SOURCES metrics_test.cpp metrics_test_flicker.cpp USES sheen_metrics)
