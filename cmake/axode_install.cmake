# Installation, and the files by which other projects find axode: find_package(axode CONFIG [COMPONENTS core
# io view fmi batch codegen]) and pkg-config.
include(CMakePackageConfigHelpers)

install(TARGETS axode_core axode_float axode_axode EXPORT axode-core-targets)
install(TARGETS axode_io EXPORT axode-io-targets)
install(TARGETS axode_view EXPORT axode-view-targets)
install(TARGETS axode_fmi EXPORT axode-fmi-targets)
install(TARGETS axode_batch EXPORT axode-batch-targets)
install(TARGETS axode_codegen EXPORT axode-codegen-targets)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/axode DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN *.hpp)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
if(TARGET axode_command)
  install(TARGETS axode_command)
  install(PROGRAMS $<TARGET_FILE:axode_study> TYPE BIN OPTIONAL)  # where it was built
  if(TARGET axode_fmu)
    install(TARGETS axode_fmu DESTINATION lib/axode)
  endif()
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/examples/robots DESTINATION ${CMAKE_INSTALL_DATADIR}/axode OPTIONAL)
  if(AXODE_PAGE)
    install(FILES ${AXODE_PAGE} DESTINATION ${CMAKE_INSTALL_DATADIR}/axode/viewer)
  endif()
  install(FILES ${PROJECT_BINARY_DIR}/share/axode DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
  install(FILES ${PROJECT_BINARY_DIR}/share/_axode DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions)
  install(FILES ${PROJECT_BINARY_DIR}/share/axode.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
  install(FILES ${PROJECT_BINARY_DIR}/share/axode.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
endif()

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/axode)
foreach(component core io view fmi batch codegen)
  install(EXPORT axode-${component}-targets NAMESPACE axode:: DESTINATION ${package_dir})
endforeach()
# Matrices of Eigen are arguments of functions in the library, so that programs that link to it need the
# version of Eigen with which it was built: 3.4, 5, ...
set(EIGEN_LIKE_OURS ${Eigen3_VERSION_MAJOR})
if(Eigen3_VERSION VERSION_LESS 5)
  set(EIGEN_LIKE_OURS 3.4)
endif()
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/axode-config.cmake.in
                              ${PROJECT_BINARY_DIR}/axode-config.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/axode-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/axode-config.cmake ${PROJECT_BINARY_DIR}/axode-config-version.cmake
        DESTINATION ${package_dir})

# Programs that link to static libraries need the private dependencies of these too.
set(PKG_CONFIG_IO_REQUIRES "Requires: axode tinyxml2")
set(PKG_CONFIG_VIEW_REQUIRES "Requires: axode tinyxml2 qhull_r")
set(PKG_CONFIG_FMI_REQUIRES "Requires: axode-io tinyxml2")
set(PKG_CONFIG_BATCH_REQUIRES "Requires: axode tbb")
if(BUILD_SHARED_LIBS)
  set(PKG_CONFIG_IO_REQUIRES "Requires: axode")
  set(PKG_CONFIG_VIEW_REQUIRES "Requires: axode")
  set(PKG_CONFIG_FMI_REQUIRES "Requires: axode-io")
  set(PKG_CONFIG_BATCH_REQUIRES "Requires: axode")
endif()
cmake_path(RELATIVE_PATH CMAKE_INSTALL_FULL_INCLUDEDIR BASE_DIRECTORY
           ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig OUTPUT_VARIABLE PKG_CONFIG_INCLUDEDIR)
foreach(package axode axode-io axode-view axode-fmi axode-batch axode-codegen)
  configure_file(${CMAKE_CURRENT_LIST_DIR}/${package}.pc.in ${PROJECT_BINARY_DIR}/${package}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${package}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endforeach()
