# What `cmake --install` lays down: programs in bin, libequistream with its CMake and pkg-config files in lib, the
# headers for hosts in include/equistream. Each finds the rest from where it lies itself, so the tree may be moved.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

file(RELATIVE_PATH lib_from_bin ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
set(CMAKE_INSTALL_RPATH $ORIGIN/${lib_from_bin})

# The component of rules that name none (Packages.cmake).
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME tools)

install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
# The headers cite it.
install(FILES docs/conventions.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT dev)

# find_package(equistream COMPONENTS plugin client): a component's targets are installed by its own folder.
write_basic_package_version_file(equistreamConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/equistreamConfigVersion.cmake ${CMAKE_CURRENT_LIST_DIR}/equistreamConfig.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/equistream COMPONENT dev)

# For *.pc.in.
set(pkgconfig_dir ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig)
file(RELATIVE_PATH lib_from_pkgconfig ${pkgconfig_dir} ${CMAKE_INSTALL_FULL_LIBDIR})
file(RELATIVE_PATH include_from_pkgconfig ${pkgconfig_dir} ${CMAKE_INSTALL_FULL_INCLUDEDIR})
