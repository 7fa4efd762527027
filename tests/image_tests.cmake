sheen_test(
    image SOURCES image_test.cpp image_test_atomic.cpp image_test_tonemap.cpp image_test_decode.cpp USES sheen_image OpenEXR::OpenEXR PNG::PNG PkgConfig::TURBOJPEG PkgConfig::WEBP)
