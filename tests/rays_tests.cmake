sheen_test(rays SOURCES rays_test.cpp rays_test_origin.cpp rays_test_cells.cpp USES sheen_rays sheen_reference)
