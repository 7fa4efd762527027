sheen_test(splat SOURCES splat_test.cpp USES sheen_splat)
