sheen_test(gather SOURCES gather_test.cpp gather_test_closer.cpp gather_test_integrate.cpp
                          gather_test_raster.cpp gather_test_motion.cpp gather_test_strata.cpp gather_test_log.cpp
           USES sheen_gather sheen_reference fmt::fmt)
