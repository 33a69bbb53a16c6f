# The library: axode::axode (standard library and Eigen's headers only), axode::io (the readers and writers of files),
# axode::batch (many states at once; oneTBB) and axode::codegen (C source for one mechanism). Sources lie beside their
# headers in axode/<floor>/.

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
foreach(floor lie scalar model kinematics dynamics derivatives integration)
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/axode/${floor}/*.cpp)
  target_sources(axode_core PRIVATE ${sources})
  file(GLOB templates CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/axode/${floor}/*.cpp.in)
  foreach(template IN LISTS templates)
    set(reps ${AXODE_REPRESENTATIONS})
    if(template MATCHES "/(inverse_dynamics|forward_dynamics|mass_matrix)\\.cpp\\.in$")
      list(APPEND reps Fast)
    endif()
    axode_instantiate(axode_core ${template} REPS ${reps} SCALARS ${AXODE_SCALARS})
  endforeach()
endforeach()

# Many states at once: the same kernels for each instruction set, chosen at run time.
find_package(TBB REQUIRED)
axode_add_library(axode_batch batch)
target_sources(axode_batch PRIVATE ${PROJECT_SOURCE_DIR}/axode/batch/batch.cpp)
target_link_libraries(axode_batch PUBLIC axode::axode PRIVATE TBB::tbb)
set(options_of_sse2 -mno-avx)
set(options_of_avx2 -mno-avx512f -mavx2 -mfma)
set(options_of_avx512 -mavx512f -mavx512dq -mavx512vl -mavx512bw -mavx2 -mfma -mprefer-vector-width=512)
set(bytes_of_sse2 16)
set(bytes_of_avx2 32)
set(bytes_of_avx512 64)
foreach(ISA sse2 avx2 avx512)
  foreach(T double float)
    if(T STREQUAL double)
      math(EXPR LANES "${bytes_of_${ISA}} / 8")
    else()
      math(EXPR LANES "${bytes_of_${ISA}} / 4")
    endif()
    set(unit ${PROJECT_BINARY_DIR}/generated/axode/batch/kernels_${ISA}_${T}.cpp)
    configure_file(${PROJECT_SOURCE_DIR}/axode/batch/kernels.cpp.in ${unit} @ONLY)
    target_sources(axode_batch PRIVATE ${unit})
    set_source_files_properties(${unit} PROPERTIES COMPILE_OPTIONS "${options_of_${ISA}}")
  endforeach()
endforeach()

axode_add_library(axode_codegen codegen)
file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/axode/codegen/*.cpp)
target_sources(axode_codegen PRIVATE ${sources})
target_link_libraries(axode_codegen PUBLIC axode::axode)
target_compile_definitions(axode_codegen PRIVATE AXODE_VERSION="${PROJECT_VERSION}")

axode_add_library(axode_io io)
file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/axode/io/*.cpp)
target_sources(axode_io PRIVATE ${sources})
target_link_libraries(axode_io PUBLIC axode::axode PRIVATE tinyxml2::tinyxml2)
