sheen_test(receivers SOURCES receivers_test.cpp receivers_test_lobes.cpp USES sheen_receivers)
