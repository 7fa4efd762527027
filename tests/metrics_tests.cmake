sheen_test(metrics SOURCES metrics_test.cpp USES sheen_metrics)
