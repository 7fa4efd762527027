sheen_test(cache SOURCES cache_test.cpp cache_test_integrate.cpp cache_test_placement.cpp
                         cache_test_disagreement.cpp cache_test_ray_gather.cpp
           USES sheen_cache)
