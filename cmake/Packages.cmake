# `cpack --config BUILD/CPackConfig.cmake` makes Debian packages of what was built: a component a package. Tried in a fresh
# root by tests/install/packages_test.py.
#
# A component of an install rule is its package. Rules without one are of `tools` (Install.cmake).
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "the equistream authors <equistream@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Stream path-traced scenes to a VR headset")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_COMPONENTS_ALL plugin client client_modules dev tools python3)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_LIBRARY_OUTPUT_DIRECTORY})
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)

# debian_package(COMPONENT NAME SECTION SUMMARY [DEPENDS ...] [RECOMMENDS ...]): dependencies beside those of its binaries.
function(debian_package component name section summary)
  cmake_parse_arguments(PARSE_ARGV 4 P "" "" "DEPENDS;RECOMMENDS")
  string(TOUPPER ${component} key)
  list(JOIN P_DEPENDS ", " depends)
  list(JOIN P_RECOMMENDS ", " recommends)
  foreach(pair "NAME=${name}" "SECTION=${section}" "DEPENDS=${depends}" "RECOMMENDS=${recommends}")
    string(REGEX MATCH "^([A-Z]+)=(.*)$" pair "${pair}")
    set(CPACK_DEBIAN_${key}_PACKAGE_${CMAKE_MATCH_1} "${CMAKE_MATCH_2}" PARENT_SCOPE)
  endforeach()
  set(CPACK_COMPONENT_${key}_DESCRIPTION "${summary}" PARENT_SCOPE)
  install(FILES ${CMAKE_BINARY_DIR}/copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} COMPONENT ${component} EXCLUDE_FROM_ALL)
endfunction()

# Debian wants each package's licences in one file. The colour configuration inside the programs has its own.
file(READ LICENSE ours)
file(READ plugin/colour/cg-config.LICENSE colours)
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/copyright CONTENT "@ours@\nThe colour configuration inside the programs and libraries:\n\n@colours@" @ONLY)

get_target_property(plugin_abi equistream SOVERSION)
get_target_property(client_abi equistream_client_library SOVERSION)
set(same "(= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})")
debian_package(plugin libequistream${plugin_abi} libs "Spherical cameras, film, AOVs and EXR export for any renderer")
debian_package(client libequistream-client${client_abi} libs "Shows streams of path-traced spheres in any program: both eyes"
  RECOMMENDS "libequistream-client${client_abi}-modules ${same}")
# Apart, because OpenImageIO, with which they read scenes, depends on half a gigabyte.
debian_package(client_modules libequistream-client${client_abi}-modules libs "OpenGL and ray casting for libequistream_client"
  DEPENDS "libequistream-client${client_abi} ${same}" RECOMMENDS libegl1 libgl1-mesa-dri)
debian_package(dev libequistream-dev libdevel "Headers, pkg-config and CMake files of libequistream and libequistream_client"
  DEPENDS "libequistream${plugin_abi} ${same}" "libequistream-client${client_abi} ${same}" RECOMMENDS libglm-dev)
debian_package(tools equistream graphics "Renders, codes, serves, plays and shows path-traced spheres: the commands"
  DEPENDS "libequistream${plugin_abi} ${same}" RECOMMENDS libegl1 libgl1-mesa-dri "python3-equistream ${same}")
if(TARGET equistream_core)
  string(REGEX MATCH "[0-9]+$" next ${EQUISTREAM_PYTHON_VERSION})
  math(EXPR next "${next} + 1")
  debian_package(python3 python3-equistream python "Frames, streams and reprojection as numpy arrays"
    DEPENDS "python3 (>= ${EQUISTREAM_PYTHON_VERSION})" "python3 (<< 3.${next})" python3-numpy)
  # Where `study` and `fit` look: a Python in a virtual environment finds it there, and none of Debian's other packages.
  file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/python3)
  file(RELATIVE_PATH module /${CMAKE_INSTALL_LIBDIR}/equistream/python /lib/python3/dist-packages/equistream)
  file(CREATE_LINK ${module} ${CMAKE_BINARY_DIR}/python3/equistream SYMBOLIC)
  install(FILES ${CMAKE_BINARY_DIR}/python3/equistream DESTINATION ${CMAKE_INSTALL_LIBDIR}/equistream/python
    COMPONENT python3 EXCLUDE_FROM_ALL)
else()
  list(REMOVE_ITEM CPACK_COMPONENTS_ALL python3)
endif()
include(CPack)
