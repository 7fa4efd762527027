sheen_test(sh SOURCES sh_test.cpp sh_test_brdf.cpp sh_test_projection.cpp USES sheen_sh sheen_scene)
