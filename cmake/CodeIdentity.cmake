# code_identity(TARGET LIBRARIES a b ... FOLDERS x y ... [FILES f ...])
#
# Gives TARGET a function `const char* equistream::code_identity()`: eight hexadecimal digits over the C++ sources in
# FOLDERS (not below them) and FILES, all relative to the root. It is looked at anew whenever one of LIBRARIES, which are
# made of those sources, is linked: so no list of headers can be out of date, and where nothing is built nothing runs. It
# says nothing of compilers and of libraries from elsewhere.
function(code_identity target)
  cmake_parse_arguments(I "" "" "LIBRARIES;FOLDERS;FILES" ${ARGN})
  set(script ${CMAKE_SOURCE_DIR}/cmake/write_code_identity.cmake)
  set(out ${CMAKE_CURRENT_BINARY_DIR}/code_identity.cpp)
  set(files ${I_FILES})
  list(TRANSFORM files PREPEND ${CMAKE_SOURCE_DIR}/)
  add_custom_command(OUTPUT ${out}
    COMMAND ${CMAKE_COMMAND} -D ROOT=${CMAKE_SOURCE_DIR} -D OUT=${out} -D "FOLDERS=${I_FOLDERS}" -D "FILES=${I_FILES}"
      -P ${script}
    DEPENDS ${I_LIBRARIES} ${files} ${script}
    VERBATIM)
  target_sources(${target} PRIVATE ${out})
endfunction()
