sheen_test(hints SOURCES hints_test.cpp USES sheen_hints)
