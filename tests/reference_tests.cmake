sheen_test(reference SOURCES reference_test.cpp USES sheen_reference)
