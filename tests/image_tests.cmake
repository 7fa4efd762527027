sheen_test(
    image SOURCES image_test.cpp image_test_atomic.cpp image_test_tonemap.cpp image_test_decode.cpp image_test_cryptomatte.cpp
          USES nlohmann_json::nlohmann_json sheen_image OpenEXR::OpenEXR PNG::PNG PkgConfig::TURBOJPEG PkgConfig::WEBP)
