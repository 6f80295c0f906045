# Run by code_identity (CodeIdentity.cmake) at build time.
list(TRANSFORM FOLDERS PREPEND ${ROOT}/ OUTPUT_VARIABLE patterns)
set(headers ${patterns})
list(TRANSFORM patterns APPEND /*.cpp)
list(TRANSFORM headers APPEND /*.h)
file(GLOB sources RELATIVE ${ROOT} ${patterns} ${headers})
list(APPEND sources ${FILES})
list(SORT sources)
set(text "")
foreach(source IN LISTS sources)
  file(SHA256 ${ROOT}/${source} hash)
  string(APPEND text "${source} ${hash}\n")
endforeach()
string(SHA256 identity "${text}")
string(SUBSTRING ${identity} 0 8 identity)
# Written only if it differs.
file(CONFIGURE OUTPUT ${OUT} CONTENT
  "namespace equistream {\nconst char* code_identity();\nconst char* code_identity() { return \"${identity}\"; }\n}\n")
