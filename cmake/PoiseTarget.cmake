# What every target of the project is built with. Settings belong to targets, never to directories.
function(poise_target_settings target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF)
  # The same bits from every compiler and on every instruction set: no contraction to fused multiply-add.
  target_compile_options(${target} PRIVATE
    -ffp-contract=off -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wdouble-promotion
    -Wold-style-cast -Wnon-virtual-dtor -Woverloaded-virtual -Wcast-qual -Wformat=2)
  # The superword vectorizer of GCC 12 (on from -O2) rounds differently from one set of files in a unit to the next:
  # the candidates of a tree (cover/deep_candidates.cpp) differ between -O1 and -O2 where it is on.
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(${target} PRIVATE -fno-tree-slp-vectorize)
  endif()
  # GCC 12 warns falsely of overlap and of sizes in `"text" + std::string` when it inlines (GCC bug 105651).
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    target_compile_options(${target} PRIVATE -Wno-restrict -Wno-stringop-overflow -Wno-array-bounds)
  endif()
  if(POISE_WERROR)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
  if(POISE_ASSERTIONS)
    target_compile_definitions(${target} PRIVATE POISE_ASSERTIONS=1)
  endif()
  if(POISE_SANITIZE)
    target_compile_options(${target} PRIVATE -fsanitize=${POISE_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
    # Checks of each address: what is beyond an object the address sanitizer finds too; addresses that are not aligned and wrong dynamic
    # types it does not.
    if(POISE_SANITIZE MATCHES "undefined")
      target_compile_options(${target} PRIVATE -fno-sanitize=alignment,object-size,pointer-overflow,vptr)
    endif()
    # A function with thousands of accesses calls the check instead of holding a copy of it for each: a file of lanes takes half a minute to
    # compile instead of nine.
    if(POISE_SANITIZE MATCHES "address" AND CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
      target_compile_options(${target} PRIVATE "SHELL:-mllvm -asan-instrumentation-with-call-threshold=300")
    endif()
    target_link_options(${target} PRIVATE -fsanitize=${POISE_SANITIZE})
    # Instrumented code hides from GCC 12 what its warnings go by: it complains of <regex> itself, and of operator new and
    # delete that are replaced together.
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
      target_compile_options(${target} PRIVATE -Wno-maybe-uninitialized -Wno-mismatched-new-delete)
    endif()
  endif()
  # Files in one unit read the headers of others once and share what they make of templates: a first build takes a
  # quarter of the time. A build without it finds missing includes. The largest target makes units enough for two cores.
  if(POISE_UNITY)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 40)
    target_compile_options(${target} PRIVATE -Wno-shadow)
  endif()
endfunction()

# poise_seldom_hot(TARGET): it waits for the library, for files or for the user; optimised less, which takes a third off the time to
# compile it.
function(poise_seldom_hot target)
  if(CMAKE_BUILD_TYPE STREQUAL "Release")
    target_compile_options(${target} PRIVATE -O1)
    # GCC 12 sees less of std::optional then, and complains of values that are there.
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
      target_compile_options(${target} PRIVATE -Wno-maybe-uninitialized)
    endif()
  endif()
endfunction()

# poise_fuzzed(TARGET): with POISE_FUZZ, a fuzzer sees which branches of it are taken.
function(poise_fuzzed target)
  if(POISE_FUZZ)
    target_compile_options(${target} PRIVATE -fsanitize=fuzzer-no-link)
  endif()
endfunction()

# poise_library(TARGET EXPORT-NAME): one layer of the library.
function(poise_library target name)
  add_library(${target})
  add_library(poise::${name} ALIAS ${target})
  # Position-independent, so that plugins and the Python module can hold them. That costs nothing where a compiler may
  # still inline what another library could replace: callgrind counts the same instructions in every entry of the ledger.
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  poise_target_settings(${target})
  target_compile_options(${target} PRIVATE -fno-semantic-interposition)
endfunction()

# poise_public_headers(TARGET header...): what users of the target may include; each must compile alone.
function(poise_public_headers target)
  list(TRANSFORM ARGN PREPEND "${PROJECT_SOURCE_DIR}/include/poise/")
  target_sources(${target} PUBLIC FILE_SET HEADERS BASE_DIRS "${PROJECT_SOURCE_DIR}/include" FILES ${ARGN})
  set_target_properties(${target} PROPERTIES VERIFY_INTERFACE_HEADER_SETS ON)
endfunction()

# poise_alone(TARGET file...): these do not share a unit with others, since they are read once per instruction set or give names of their own
# to what others name alike.
function(poise_alone target)
  set_source_files_properties(${ARGN} TARGET_DIRECTORY ${target} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# poise_precompile(TARGET header...): with POISE_PRECOMPILE, these and the usual standard headers are read once a target.
# It pays where a target has several units.
function(poise_precompile target)
  if(POISE_PRECOMPILE)
    target_precompile_headers(${target} PRIVATE ${ARGN} <algorithm> <array> <charconv> <chrono> <cmath> <cstdint> <filesystem>
      <fstream> <functional> <limits> <memory> <numeric> <optional> <span> <string> <string_view> <utility> <variant> <vector>)
  endif()
endfunction()
