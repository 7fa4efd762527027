sheen_test(record SOURCES record_test.cpp USES sheen_record)
