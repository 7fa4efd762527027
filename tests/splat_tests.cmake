sheen_test(splat SOURCES splat_test.cpp splat_test_estimate.cpp splat_test_upsample.cpp USES sheen_splat)
