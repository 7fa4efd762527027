if(SHEEN_VIEWER)
    sheen_test(viewer SOURCES viewer_test.cpp USES sheen_viewer sheen_metrics)
    # In a real window, of an X server of its own.
    add_test(NAME Viewer.InAWindow COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/window_test.py $<TARGET_FILE:sheen>
                                           ${PROJECT_SOURCE_DIR}/scenes/cornell_diffuse.glb)
endif()
