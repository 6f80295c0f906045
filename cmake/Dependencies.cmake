# Every library we use, found once. Debian 12's OpenColorIO and OpenImageIO CMake packages are broken
# (wrong prefix; wants OpenCV): those two, FFmpeg and ISA-L come by pkg-config.
find_package(Threads REQUIRED)
find_package(glm REQUIRED)
find_package(OpenEXR REQUIRED)
find_package(Imath REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(embree 4 QUIET)
if(NOT embree_FOUND)
  find_package(embree 3 REQUIRED)
endif()
find_package(TinyGLTF REQUIRED)
find_package(TBB REQUIRED)

find_package(PkgConfig REQUIRED)
pkg_check_modules(oiio REQUIRED IMPORTED_TARGET OpenImageIO)
pkg_check_modules(ocio REQUIRED IMPORTED_TARGET OpenColorIO)
pkg_check_modules(libav REQUIRED IMPORTED_TARGET libavcodec libavformat libavutil libswscale)
pkg_check_modules(isal REQUIRED IMPORTED_TARGET libisal)

if(BUILD_TESTING)
  find_package(GTest REQUIRED)
endif()
