sheen_test(chart SOURCES chart_test.cpp chart_test_report.cpp chart_test_sample.cpp USES sheen_chart)
target_compile_definitions(chart_test PRIVATE SHEEN_PROGRAM="$<TARGET_FILE:sheen>")
add_dependencies(chart_test sheen)

add_executable(make_sample_report make_sample_report.cpp chart_test_sample.cpp)
target_link_libraries(make_sample_report PRIVATE sheen_chart)
add_test(NAME Report.WorksInABrowser COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/report_test.py
                                             $<TARGET_FILE:make_sample_report>)
