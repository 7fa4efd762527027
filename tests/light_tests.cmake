sheen_test(light SOURCES light_test.cpp light_test_cells.cpp light_test_direct.cpp light_test_lamps.cpp light_test_bounces.cpp light_test_many.cpp USES sheen_light sheen_reference fmt::fmt)
