# The library: axode::axode (standard library and Eigen's headers only) and axode::io (the readers and writers
# of files). Sources lie beside their headers in axode/<floor>/.

find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(tinyxml2 REQUIRED)

set(AXODE_REPRESENTATIONS BodyFixed Spatial Hybrid Mixed)
set(AXODE_SCALARS double float)

# Target names differ from the file names because the command `axode` takes the plain one.
function(axode_add_library target name)
  add_library(${target})
  add_library(axode::${name} ALIAS ${target})
  axode_compile_options(${target})
  target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                                              $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  set_target_properties(
    ${target}
    PROPERTIES EXPORT_NAME ${name}
               VERSION ${PROJECT_VERSION}
               SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
               INSTALL_RPATH "$ORIGIN"
               LINKER_LANGUAGE CXX
               ARCHIVE_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib
               LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib)
endfunction()

axode_add_library(axode_core axode)
set_target_properties(axode_core PROPERTIES OUTPUT_NAME axode)
target_link_libraries(axode_core PUBLIC Eigen3::Eigen)
foreach(floor lie scalar model kinematics dynamics derivatives integration batch)
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/axode/${floor}/*.cpp)
  target_sources(axode_core PRIVATE ${sources})
  file(GLOB templates CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/axode/${floor}/*.cpp.in)
  foreach(template IN LISTS templates)
    axode_instantiate(axode_core ${template} REPS ${AXODE_REPRESENTATIONS} SCALARS ${AXODE_SCALARS})
  endforeach()
endforeach()

axode_add_library(axode_io io)
file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/axode/io/*.cpp)
target_sources(axode_io PRIVATE ${sources})
target_link_libraries(axode_io PUBLIC axode::axode PRIVATE tinyxml2::tinyxml2)
