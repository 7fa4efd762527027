sheen_test(stress SOURCES stress_test.cpp USES sheen_stress sheen_render)
