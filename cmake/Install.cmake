# What `cmake --install` lays down: programs in bin, libequistream with its CMake and pkg-config files in lib, the
# headers for hosts in include/equistream. Each finds the rest from where it lies itself, so the tree may be moved.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

file(RELATIVE_PATH lib_from_bin ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
set(CMAKE_INSTALL_RPATH $ORIGIN/${lib_from_bin})

install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
