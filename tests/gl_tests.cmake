sheen_test(gl SOURCES gl_test.cpp gl_test_twins.cpp USES sheen_gl sheen_cache)
