sheen_test(hemisphere SOURCES hemisphere_test.cpp USES sheen_hemisphere sheen_scene)
