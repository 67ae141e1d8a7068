# SPDX-License-Identifier: Apache-2.0
configure_file(cmake/installed_paths.cmake.in installed_paths.cmake @ONLY)

# install_configured(NAME.in DESTINATION): replaces @CMAKE_INSTALL_FULL_...@ in a file when it is
# installed, and installs it as NAME.
function(install_configured input destination)
  cmake_path(GET input STEM LAST_ONLY name)
  install(CODE "
    include(\"${PROJECT_BINARY_DIR}/installed_paths.cmake\")
    configure_file(\"${CMAKE_CURRENT_SOURCE_DIR}/${input}\" \"${CMAKE_CURRENT_BINARY_DIR}/${name}\" @ONLY)
    file(INSTALL DESTINATION \"\${CMAKE_INSTALL_PREFIX}/${destination}\" TYPE FILE
         FILES \"${CMAKE_CURRENT_BINARY_DIR}/${name}\")")
endfunction()

# install_once(FILE FOLDER): installs a file that people edit into FOLDER of the system's
# configurations, unless there is one.
function(install_once file folder)
  cmake_path(GET file FILENAME name)
  install(CODE "
    include(\"${PROJECT_BINARY_DIR}/installed_paths.cmake\")
    set(folder \"\${CMAKE_INSTALL_FULL_SYSCONFDIR}/${folder}\")
    if(EXISTS \"\$ENV{DESTDIR}\${folder}/${name}\")
      message(STATUS \"Kept: \$ENV{DESTDIR}\${folder}/${name}\")
    else()
      file(INSTALL DESTINATION \"\${folder}\" TYPE FILE FILES \"${file}\")
    endif()")
endfunction()
