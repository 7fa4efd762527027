sheen_test(core SOURCES core_test.cpp USES sheen_core)
