sheen_test(
    image SOURCES image_test.cpp image_test_atomic.cpp image_test_tonemap.cpp USES sheen_image OpenEXR::OpenEXR PNG::PNG)
