sheen_test(raster SOURCES raster_test.cpp raster_test_clusters.cpp raster_test_light.cpp
           USES sheen_raster sheen_reference)
