add_test(NAME Browser.ShowsLightmaps COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/browser_test.py $<TARGET_FILE:sheen>
                                             ${PROJECT_BINARY_DIR}/three)
set_tests_properties(Browser.ShowsLightmaps PROPERTIES SKIP_RETURN_CODE 77)
