# The commit and flags that every number is stored with, and what decides the bits of a built tree, as headers that are
# rewritten only when they change.
find_package(Git QUIET)
set(POISE_BUILD_INFO_DIR "${PROJECT_BINARY_DIR}/generated")
add_custom_target(poise_build_info
  COMMAND ${CMAKE_COMMAND} -DGIT=${GIT_EXECUTABLE} -DSOURCE_DIR=${PROJECT_SOURCE_DIR}
          -DOUTPUT=${POISE_BUILD_INFO_DIR} -DVERSION=${PROJECT_VERSION}
          "-DCOMPILER=${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}" -DBUILD_TYPE=${CMAKE_BUILD_TYPE}
          -DSANITIZE=${POISE_SANITIZE} -DASSERTIONS=${POISE_ASSERTIONS}
          -P ${PROJECT_SOURCE_DIR}/cmake/write_build_info.cmake
  BYPRODUCTS "${POISE_BUILD_INFO_DIR}/build_info.h" "${POISE_BUILD_INFO_DIR}/geometry_hash.h" VERBATIM)

# poise_use_build_info(TARGET): its files may include build_info.h and geometry_hash.h.
function(poise_use_build_info target)
  target_include_directories(${target} PRIVATE "${POISE_BUILD_INFO_DIR}")
  add_dependencies(${target} poise_build_info)
endfunction()
