# Debian packages: `cpack` in a build folder, or all of it by cmake/package.sh. One package for the command, one for the
# studies, one for the libraries with their headers, and with POISE_PYTHON one for the Python module.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME poise)
set(CPACK_PACKAGE_VERSION "${POISE_PACKAGE_VERSION}")
# Each package has its own.
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")
set(CPACK_PACKAGE_VENDOR "The Poise authors")
set(CPACK_PACKAGE_CONTACT "The Poise authors <poise@packages.invalid>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_COMPONENTS_ALL scheduler poise assets scene command studies poise-doc study-doc dev-doc)

# poise_package(GROUP NAME SECTION SUMMARY TEXT COMPONENT...)
function(poise_package group name section summary text)
  string(TOUPPER "${group}" upper)
  foreach(component IN LISTS ARGN)
    string(TOUPPER "${component}" part)
    set(CPACK_COMPONENT_${part}_GROUP "${group}" PARENT_SCOPE)
  endforeach()
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME "${name}" PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION "${section}" PARENT_SCOPE)
  set(CPACK_COMPONENT_GROUP_${upper}_DESCRIPTION "${summary}\n${text}" PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_DESCRIPTION "${summary}\n${text}" PARENT_SCOPE)
endfunction()

poise_package(program poise science "scenes of many rigid bodies, stepped inside a time budget"
  "Runs scenes of many rigid bodies under a deadline: each frame a scheduler\nspends the time that there is on the collisions that a viewer would notice.\nReports say which frames were late and why, and how far the motion is from\nfull refinement. Runs can be recorded, replayed to the bit and looked at in\na browser."
  command poise-doc)
poise_package(studies poise-study science "studies of poise, which measure time and accuracy"
  "The studies behind the tables and pictures of the documentation of poise, for\n`poise study`: deadlines met, error against time, accuracy against closed\nforms, sphere trees, scaling."
  studies study-doc)
poise_package(dev libpoise-dev libdevel "rigid bodies inside a time budget, libraries and headers"
  "Static libraries, headers, CMake and pkg-config files of poise: the scheduler\nalone, worlds of rigid bodies, files of meshes and sphere trees, scenes and\nrecords."
  scheduler poise assets scene dev-doc)
if(POISE_PYTHON)
  find_package(Python COMPONENTS Interpreter)
  math(EXPR POISE_NEXT_PYTHON "${Python_VERSION_MINOR} + 1")
  list(APPEND CPACK_COMPONENTS_ALL python python-doc)
  poise_package(python python3-poise python "rigid bodies inside a time budget, Python module"
    "Worlds of rigid bodies stepped inside a time budget, from Python: shapes,\nsteps, states as NumPy arrays, contacts, cues and policies, scenes, replay of\nrecords, results as data frames."
    python python-doc)
  # The module is that of one version of Python.
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "python3 (>= ${Python_VERSION_MAJOR}.${Python_VERSION_MINOR}), python3 (<< ${Python_VERSION_MAJOR}.${POISE_NEXT_PYTHON}), python3-numpy")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-pandas, python3-matplotlib, poise")
endif()
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "poise-study, gnuplot-nox, python3-optuna")
set(CPACK_DEBIAN_STUDIES_PACKAGE_DEPENDS "poise (= ${POISE_PACKAGE_VERSION})")
set(CPACK_DEBIAN_STUDIES_PACKAGE_SUGGESTS "gnuplot-nox")
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS
  "libeigen3-dev, libtbb-dev, libhwy-dev, libxxhash-dev, libfmt-dev, libtinyxml2-dev, libyaml-cpp-dev, zlib1g-dev")

# What Debian asks of each package: licence and changelog, and of programs their pages in the manual. For packages alone:
# `cmake --install` does without, unless it names the component.
file(STRINGS "${PROJECT_SOURCE_DIR}/LICENSE" lines)
set(POISE_LICENSE_TEXT "")
foreach(line IN LISTS lines)
  if(NOT line MATCHES "^(MIT License|Copyright.*)$")
    string(APPEND POISE_LICENSE_TEXT " ${line}\n")
  endif()
endforeach()
string(REPLACE "\n \n" "\n .\n" POISE_LICENSE_TEXT "\n${POISE_LICENSE_TEXT}")
string(REGEX REPLACE "^(\n \\.|\n )*\n" "" POISE_LICENSE_TEXT "${POISE_LICENSE_TEXT}")
file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/debian/copyright" @ONLY CONTENT
"Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: poise

Files: *
Copyright: 2026 The Poise authors
License: Expat
@POISE_LICENSE_TEXT@")

# poise_package_docs(COMPONENT PACKAGE [TARGET]): these of a package, and the pages of a program.
function(poise_package_docs component package)
  install(FILES "${PROJECT_BINARY_DIR}/debian/copyright" DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/${package}"
    COMPONENT ${component} EXCLUDE_FROM_ALL)
  set(share "\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DATADIR}")
  install(CODE "execute_process(COMMAND \"${PROJECT_SOURCE_DIR}/cmake/debian_changelog.sh\" \"${POISE_PACKAGE_VERSION}\"
    \"${CPACK_PACKAGE_CONTACT}\" \"${share}/doc/${package}/changelog.gz\" COMMAND_ERROR_IS_FATAL ANY)"
    COMPONENT ${component} EXCLUDE_FROM_ALL)
  foreach(target IN LISTS ARGN)
    install(CODE "execute_process(COMMAND \"${PROJECT_SOURCE_DIR}/cmake/make_man_pages.sh\" \"${share}/man/man1\"
      \"$<TARGET_FILE:${target}>\" COMMAND_ERROR_IS_FATAL ANY)" COMPONENT ${component} EXCLUDE_FROM_ALL)
  endforeach()
endfunction()

poise_package_docs(poise-doc poise poise_command)
poise_package_docs(study-doc poise-study poise_study)
poise_package_docs(dev-doc libpoise-dev)
if(POISE_PYTHON)
  poise_package_docs(python-doc python3-poise)
endif()
include(CPack)
