sheen_test(rays SOURCES rays_test.cpp USES sheen_rays)
