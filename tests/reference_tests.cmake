sheen_test(reference SOURCES reference_test.cpp reference_test_lights.cpp reference_test_sampling.cpp
                             reference_test_variance.cpp
           USES sheen_reference)
