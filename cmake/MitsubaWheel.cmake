# Mitsuba 3 as pip installs it, found beside the Python that EQUISTREAM_PYTHON names without importing anything (import
# would start drjit and look for GPUs). Gives
#   mitsuba::wheel                what a plugin or an embedding program compiles and links with
#   EQUISTREAM_MITSUBA_FOLDER     the wheel's own folder: libmitsuba, its plugins, its command line
#   EQUISTREAM_MITSUBA_VARIANTS   for which variants plugins are compiled: all in the wheel unless given
#   EQUISTREAM_WITH_MITSUBA       whether all that is there; modules that need it ask this
# Its C++ interface changes with every release and nothing in it checks that, so exactly one is accepted.
set(EQUISTREAM_PYTHON "${CMAKE_SOURCE_DIR}/build/venv/bin/python3" CACHE FILEPATH "Python with tests/requirements.txt installed")
set(EQUISTREAM_MITSUBA AUTO CACHE STRING "Mitsuba's plugins and host: AUTO (if the wheel is there), ON (or fail), OFF")
set_property(CACHE EQUISTREAM_MITSUBA PROPERTY STRINGS AUTO ON OFF)
set(EQUISTREAM_MITSUBA_VARIANTS
  scalar_rgb scalar_spectral scalar_spectral_polarized
  llvm_ad_rgb llvm_ad_mono llvm_ad_mono_polarized llvm_ad_spectral llvm_ad_spectral_polarized
  cuda_ad_rgb cuda_ad_mono cuda_ad_mono_polarized cuda_ad_spectral cuda_ad_spectral_polarized
  CACHE STRING "Mitsuba variants to compile plugins for; scalar_rgb must be among them")
set(EQUISTREAM_MITSUBA_VERSION 3.9.1)

# Sets OUT to what is wrong, or to nothing; and EQUISTREAM_MITSUBA_FOLDER, drjit_folder, nanobind_folder.
function(find_mitsuba_wheel python out)
  set(${out} "" PARENT_SCOPE)
  if(NOT EXISTS ${python})
    set(${out} "expected a Python in EQUISTREAM_PYTHON, found no ${python}" PARENT_SCOPE)
    return()
  endif()
  execute_process(COMMAND ${python} ${CMAKE_SOURCE_DIR}/cmake/find_wheels.py mitsuba==${EQUISTREAM_MITSUBA_VERSION} drjit nanobind
    OUTPUT_VARIABLE wheels ERROR_VARIABLE complaint RESULT_VARIABLE failed OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(failed)
    string(STRIP "${complaint}" complaint)
    set(${out} "${python}: ${complaint}" PARENT_SCOPE)
    return()
  endif()
  list(GET wheels 1 mitsuba_folder)
  list(GET wheels 3 drjit_folder)
  list(GET wheels 5 nanobind_folder)
  set(EQUISTREAM_MITSUBA_FOLDER ${mitsuba_folder} PARENT_SCOPE)
  set(drjit_folder ${drjit_folder} PARENT_SCOPE)
  set(nanobind_folder ${nanobind_folder} PARENT_SCOPE)
endfunction()

set(EQUISTREAM_WITH_MITSUBA OFF)
if(EQUISTREAM_MITSUBA)
  find_mitsuba_wheel(${EQUISTREAM_PYTHON} complaint)
  if(complaint STREQUAL "" AND NOT CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    set(complaint "expected an x86-64 processor, found ${CMAKE_SYSTEM_PROCESSOR}")
  endif()
  # A sanitizer's runtime must be there first, and the wheel's Python, where plugins end, comes without.
  if(complaint STREQUAL "" AND CMAKE_CXX_FLAGS MATCHES "-fsanitize")
    set(complaint "expected a build without sanitizers, found ${CMAKE_CXX_FLAGS}")
  endif()
  if(complaint STREQUAL "")
    set(EQUISTREAM_WITH_MITSUBA ON)
  elseif(EQUISTREAM_MITSUBA STREQUAL "AUTO")
    message(STATUS "Mitsuba is left out: ${complaint}")
  else()
    message(FATAL_ERROR "EQUISTREAM_MITSUBA=ON: ${complaint}")
  endif()
endif()
if(NOT EQUISTREAM_WITH_MITSUBA)
  return()
endif()

if(NOT "scalar_rgb" IN_LIST EQUISTREAM_MITSUBA_VARIANTS)
  message(FATAL_ERROR "EQUISTREAM_MITSUBA_VARIANTS: expected scalar_rgb among them (Mitsuba asks it for a plugin's type), "
    "found ${EQUISTREAM_MITSUBA_VARIANTS}")
endif()

add_library(mitsuba::wheel INTERFACE IMPORTED)
target_include_directories(mitsuba::wheel INTERFACE
  ${EQUISTREAM_MITSUBA_FOLDER}/include ${drjit_folder}/include
  ${nanobind_folder}/include ${nanobind_folder}/ext/robin_map/include)
target_compile_definitions(mitsuba::wheel INTERFACE
  NDEBUG MI_ENABLE_LLVM=1 MI_ENABLE_CUDA=1 MI_ENABLE_EMBREE=1 MI_ENABLE_AUTODIFF=1)
# The wheel's own code generation flags. Packets are laid out by -march: without it the scalar variants render black and
# then crash, with a newer one structures differ.
target_compile_options(mitsuba::wheel INTERFACE
  -march=haswell -fno-math-errno -ffp-contract=fast -fno-trapping-math -fno-strict-aliasing)
target_link_libraries(mitsuba::wheel INTERFACE
  ${EQUISTREAM_MITSUBA_FOLDER}/libmitsuba.so ${drjit_folder}/libdrjit-core.so ${drjit_folder}/libdrjit-extra.so
  ${drjit_folder}/libnanothread.so)
target_link_options(mitsuba::wheel INTERFACE
  -Wl,--no-undefined -Wl,-rpath-link,${EQUISTREAM_MITSUBA_FOLDER} -Wl,-rpath-link,${drjit_folder})
message(STATUS "Mitsuba ${EQUISTREAM_MITSUBA_VERSION}: ${EQUISTREAM_MITSUBA_FOLDER}")
