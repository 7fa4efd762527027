sheen_test(cache SOURCES cache_test_placement.cpp cache_test_disagreement.cpp cache_test_record_tree.cpp
                         cache_test_specular.cpp cache_test_creases.cpp cache_test_missed.cpp
                         cache_test_probes.cpp cache_test_temporal.cpp cache_test_kmeans.cpp
           USES sheen_cache sheen_reference fmt::fmt)
