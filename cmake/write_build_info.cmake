set(commit "unknown")
if(GIT)
  execute_process(COMMAND ${GIT} -C ${SOURCE_DIR} rev-parse --short=12 HEAD OUTPUT_VARIABLE head
                  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
  if(NOT failed)
    set(commit "${head}")
    execute_process(COMMAND ${GIT} -C ${SOURCE_DIR} status --porcelain --untracked-files=no
                    OUTPUT_VARIABLE changes ERROR_QUIET)
    if(changes)
      string(APPEND commit "+changes")
    endif()
  endif()
endif()
if(commit STREQUAL "unknown")
  # Sources of `git archive`, which has put the commit there.
  file(STRINGS ${SOURCE_DIR}/cmake/commit.txt archived LIMIT_COUNT 1)
  if(archived MATCHES "^[0-9a-f]+$")
    string(SUBSTRING "${archived}" 0 12 commit)
  endif()
endif()
set(flags "${BUILD_TYPE}")
if(SANITIZE)
  string(APPEND flags " sanitize=${SANITIZE}")
endif()
if(ASSERTIONS)
  string(APPEND flags " assertions")
endif()
# What decides the bits of a built tree, for the cache of trees. Not the compiler: tests/golden holds that GCC and Clang build the same.
file(GLOB_RECURSE sources ${SOURCE_DIR}/src/geometry/*.h ${SOURCE_DIR}/src/geometry/*.cpp
  ${SOURCE_DIR}/src/math/*.h ${SOURCE_DIR}/src/math/*.cpp)
list(APPEND sources ${SOURCE_DIR}/include/poise/mesh.h ${SOURCE_DIR}/include/poise/sphere_tree.h ${SOURCE_DIR}/include/poise/types.h)
list(SORT sources)
set(hashes "")
foreach(source IN LISTS sources)
  file(SHA256 ${source} hash)
  string(APPEND hashes "${hash}")
endforeach()
string(SHA256 geometry "${hashes}")
string(SUBSTRING "${geometry}" 0 32 geometry)

function(write_if_new file text)
  set(old "")
  if(EXISTS ${file})
    file(READ ${file} old)
  endif()
  if(NOT old STREQUAL text)
    file(WRITE ${file} "${text}")
  endif()
endfunction()
write_if_new(${OUTPUT}/build_info.h "#pragma once
#define POISE_BUILD_VERSION \"${VERSION}\"
#define POISE_BUILD_COMMIT \"${commit}\"
#define POISE_BUILD_COMPILER \"${COMPILER}\"
#define POISE_BUILD_FLAGS \"${flags}\"
")
write_if_new(${OUTPUT}/geometry_hash.h "#pragma once
#define POISE_BUILD_GEOMETRY \"${geometry}\"
")
