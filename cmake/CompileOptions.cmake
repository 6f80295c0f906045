# One place for how everything is compiled. Targets link equistream_options; nothing else sets flags.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_C_STANDARD 11)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_CXX_VISIBILITY_PRESET hidden)
set(CMAKE_C_VISIBILITY_PRESET hidden)
set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)

option(EQUISTREAM_WERROR "Warnings are errors (CI)" OFF)
option(EQUISTREAM_FUZZ "Build the libFuzzer programs of tests/fuzz, and no other tests (preset fuzz)" OFF)

add_library(equistream_options INTERFACE)
# A header is named by its path from the root.
target_include_directories(equistream_options INTERFACE ${CMAKE_SOURCE_DIR})
target_compile_options(equistream_options INTERFACE
  -Wall -Wextra $<$<COMPILE_LANGUAGE:CXX>:-Wshadow> $<$<COMPILE_LANGUAGE:CXX>:-Wconversion>
  $<$<COMPILE_LANGUAGE:CXX>:-Wno-sign-conversion>
  $<$<BOOL:${EQUISTREAM_WERROR}>:-Werror>)

# Loops over pixels: square roots and rounding inline, instead of calls that might set errno or raise exceptions nobody reads.
add_library(equistream_pixel_loops INTERFACE)
target_link_libraries(equistream_pixel_loops INTERFACE equistream_options)
target_compile_options(equistream_pixel_loops INTERFACE -O3 -fno-math-errno -fno-trapping-math)

# The same by Highway's vectors, for each instruction set, and the scalar loops too, whatever the processor has. Highway
# leaves its scalar vectors out for GCC before 12.3, which may vectorise high halves of products wrongly (GCC 106322).
# Nothing here takes those, and tests hold the scalar loops to the others.
add_library(equistream_vector_loops INTERFACE)
target_link_libraries(equistream_vector_loops INTERFACE PkgConfig::hwy equistream_pixel_loops)
target_compile_definitions(equistream_vector_loops INTERFACE HWY_COMPILE_ALL_ATTAINABLE HWY_BROKEN_EMU128=0)

find_program(CCACHE ccache)
if(CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE})
  set(CMAKE_C_COMPILER_LAUNCHER ${CCACHE})
endif()
