sheen_test(image SOURCES image_test.cpp USES sheen_image OpenEXR::OpenEXR PNG::PNG)
