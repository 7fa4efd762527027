sheen_test(cache SOURCES cache_test.cpp cache_test_integrate.cpp cache_test_placement.cpp
                         cache_test_disagreement.cpp
           USES sheen_cache)
