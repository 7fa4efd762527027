add_test(NAME Bench.RunsAndMakesTables COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/bench_test.py
                                               $<TARGET_FILE:stages> $<TARGET_FILE:sheen>)
