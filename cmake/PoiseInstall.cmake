# Each layer installs alone: `cmake --install build --component scheduler` gives its library, headers and targets, and
# each brings a file that find_package(poise COMPONENTS ...) reads. Without --component all that was built is installed.
include(CMakePackageConfigHelpers)

function(poise_install_layers)
  set(folder "${CMAKE_INSTALL_LIBDIR}/cmake/poise")
  get_target_property(type poise TYPE)
  set(POISE_STATIC OFF)
  if(type STREQUAL "STATIC_LIBRARY")
    set(POISE_STATIC ON)
  endif()
  configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/poiseConfig.cmake.in" "${PROJECT_BINARY_DIR}/poiseConfig.cmake"
    INSTALL_DESTINATION "${folder}")
  write_basic_package_version_file("${PROJECT_BINARY_DIR}/poiseConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
  # Every layer rests on the scheduler, so what all need comes with it.
  install(FILES "${PROJECT_BINARY_DIR}/poiseConfig.cmake" "${PROJECT_BINARY_DIR}/poiseConfigVersion.cmake"
    DESTINATION "${folder}" COMPONENT scheduler)
  foreach(target poise_scheduler poise poise_assets poise_scene)
    if(TARGET ${target})
      get_target_property(layer ${target} EXPORT_NAME)
      install(TARGETS ${target} EXPORT ${target} COMPONENT ${layer} FILE_SET HEADERS COMPONENT ${layer})
      install(EXPORT ${target} NAMESPACE poise:: FILE "poise-${layer}.cmake" DESTINATION "${folder}" COMPONENT ${layer})
    endif()
  endforeach()
  if(POISE_COMMAND)
    install(TARGETS poise_command COMPONENT command)
    install(DIRECTORY "${PROJECT_SOURCE_DIR}/scenes/" DESTINATION "${CMAKE_INSTALL_DATADIR}/poise/scenes" COMPONENT command)
    # Left out where the pages were not built.
    foreach(page report figures live)
      install(FILES "${PROJECT_SOURCE_DIR}/viewer/build/${page}.html" DESTINATION "${CMAKE_INSTALL_DATADIR}/poise"
        COMPONENT command OPTIONAL)
    endforeach()
    install(DIRECTORY "${PROJECT_SOURCE_DIR}/src/app/tune/" DESTINATION "${CMAKE_INSTALL_DATADIR}/poise/tune" COMPONENT command
      FILES_MATCHING PATTERN "*.py")
  endif()
  # Beside `poise`, where that looks for it; left out where only the command was built.
  if(POISE_STUDIES)
    install(TARGETS poise_study COMPONENT studies OPTIONAL)
  endif()
endfunction()
