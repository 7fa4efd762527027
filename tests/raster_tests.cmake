sheen_test(raster SOURCES raster_test.cpp raster_test_clusters.cpp raster_test_light.cpp
                          raster_test_shadow_edges.cpp
           USES sheen_raster sheen_reference sheen_metrics)
