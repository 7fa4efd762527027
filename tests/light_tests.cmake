sheen_test(light SOURCES light_test.cpp light_test_cells.cpp light_test_direct.cpp USES sheen_light sheen_reference fmt::fmt)
