# The library: axode::axode (standard library and Eigen's headers only), axode::io (the readers
# and writers of files), axode::batch (many states at once; oneTBB), axode::codegen (C source
# for one mechanism, and functions compiled from it), axode::view (pages for a browser, and
# hulls of meshes) and axode::fmi (FMUs). Sources lie beside their headers in axode/<floor>/.
# axode::axode is two archives: libaxode, which is enough for double, and libaxode_float.

find_package(tinyxml2 REQUIRED)

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

# Sources that are compiled once for each scalar, and once for each representation and scalar (AXODE_T,
# AXODE_REP, see axode/recursion/instantiate.hpp). The sources of each combination become one unit, which
# compiles in half of the time. Fast kernels for each representation, and sources that take Fast instead of a
# representation, are listed separately: these are compiled for each instruction set.
set(AXODE_PER_SCALAR
    kinematics/center_of_mass
    kinematics/higher_order/higher_order
    kinematics/higher_order/joint_screws
    kinematics/poses
    constraints/constrained_derivatives
    constraints/constrained_dynamics
    constraints/embedding/drive_elimination
    constraints/loop_system/independent_rows
    constraints/loop_system/loop_derivatives
    constraints/loop_system/loop_rows
    constraints/loop_system/loop_system
    constraints/loops
    constraints/loop_system/fast_acceleration
    derivatives/forward_dynamics_derivatives
    derivatives/geometry_derivatives
    derivatives/inverse_dynamics_derivatives
    derivatives/linearization
    derivatives/momentum_form_derivatives
    derivatives/products/products
    derivatives/rates
    derivatives/second_order/hessian
    derivatives/second_order/second_derivatives
    derivatives/spring_derivatives
    derivatives/term_derivatives
    dynamics/closed_form/coriolis
    dynamics/momentum/energy
    dynamics/mass_matrix/mass_matrix_partials
    dynamics/momentum/momentum
    dynamics/momentum/spatial_momentum_form
    dynamics/closed_form/regressor
    dynamics/springs)
set(AXODE_PER_REPRESENTATION
    kinematics/higher_order/jacobian_partials
    constraints/constrained_operational_space
    derivatives/motion_derivatives
    dynamics/momentum/body_momenta
    dynamics/momentum/momentum_form
    dynamics/joint_wrenches
    dynamics/operational_space
    dynamics/closed_form/twist_form)
set(AXODE_FAST_PER_REPRESENTATION
    kinematics/jacobian
    kinematics/twists)
set(AXODE_PER_REPRESENTATION_AND_FAST
    dynamics/forward_dynamics
    dynamics/inverse_dynamics
    dynamics/mass_matrix/mass_matrix
    dynamics/closed_form/terms)
set(AXODE_ROWS
    catalog/functions)

# Sources of kernels that exist in double only.
set(AXODE_IN_DOUBLE
    constraints/embedding/task_kernel
    constraints/embedding/task_ranks
    contact/law/contact_system
    recursion/changes)

axode_add_library(axode_core core)
set_target_properties(axode_core PROPERTIES OUTPUT_NAME axode)
target_link_libraries(axode_core PUBLIC Eigen3::Eigen)
axode_add_library(axode_float float)
target_link_libraries(axode_float PUBLIC axode_core)
add_library(axode_axode INTERFACE)
add_library(axode::axode ALIAS axode_axode)
set_target_properties(axode_axode PROPERTIES EXPORT_NAME axode)
target_link_libraries(axode_axode INTERFACE axode_float axode_core)

# axode_add_objects(<group> <name> <source>...): objects
# of a group, which axode_add_group() adds to a library.
function(axode_add_objects group name)
  add_library(${name} OBJECT ${ARGN})
  axode_compile_options(${name})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE Eigen3::Eigen)
  set_property(GLOBAL APPEND PROPERTY axode_objects_of_${group} ${name})
endfunction()

# axode_optimise_little(<target>): for targets that read and write text. GCC compiles them in two thirds of the time,
# and reading a robot takes 8 % longer (0.81 instead of 0.75 ms for the humanoid). Clang does not inline with -O1.
function(axode_optimise_little target)
  target_compile_options(${target} PRIVATE $<$<AND:$<CXX_COMPILER_ID:GNU>,$<CONFIG:Release>>:-O1>)
endfunction()

# axode_precompile(<name> <first>): a precompiled header, with the headers that nearly all sources include. It
# is that of the objects <first>, which are compiled with the same options.
function(axode_precompile name first)
  if(NOT name STREQUAL first)
    target_precompile_headers(${name} REUSE_FROM ${first})
    return()
  endif()
  target_precompile_headers(${name} PRIVATE <algorithm> <array> <cmath> <functional> <memory> <optional> <span> <string>
                            <unordered_map> <variant> <vector> ${PROJECT_SOURCE_DIR}/axode/model/model.hpp
                            ${PROJECT_SOURCE_DIR}/axode/model/workspace.hpp)
endfunction()

# axode_unite(<target> [<folder>...]): compiles many sources as one unit, because most of the time of a source goes
# to headers and templates that its neighbours use too: those of each floor or, without AXODE_LARGE_UNITS, of each
# folder. With folders given, these are units, and all other sources are one. GCC would need 3.5 GB for all of
# integration/, and as much time as for its folders.
function(axode_unite target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  if(AXODE_LARGE_UNITS)  # the names of one room are visible in the others
    target_compile_options(${target} PRIVATE -Wno-shadow)
  endif()
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)  # it takes the sources of a unit for headers
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
  endif()
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources INCLUDE REGEX "^${PROJECT_SOURCE_DIR}/.*\\.cpp$")
  foreach(source IN LISTS sources)
    cmake_path(GET source PARENT_PATH room)
    cmake_path(GET room FILENAME folder)
    cmake_path(RELATIVE_PATH room BASE_DIRECTORY ${PROJECT_SOURCE_DIR}/axode)
    if(ARGN AND NOT folder IN_LIST ARGN)
      set(room others)
    endif()
    if(AXODE_LARGE_UNITS AND NOT (CMAKE_CXX_COMPILER_ID STREQUAL GNU AND room MATCHES "^integration"))
      string(REGEX REPLACE "^([^./]+)/.*" "\\1" room ${room})
    endif()
    string(MAKE_C_IDENTIFIER ${room} room)
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${room})
  endforeach()
endfunction()

# axode_add_instances(<group> <name> <first> <definitions> <source>...): objects of the sources with these
# definitions, and with the precompiled header of <first>, which is such an object, too: GCC ignores --param where it
# was not given for the precompiled header.
function(axode_add_instances group name first definitions)
  if(NOT ARGN)
    return()
  endif()
  list(TRANSFORM ARGN PREPEND ${PROJECT_SOURCE_DIR}/axode/)
  list(TRANSFORM ARGN APPEND .cpp)
  axode_add_objects(${group} ${name} ${ARGN})
  target_compile_definitions(${name} PRIVATE ${definitions})
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)  # what is inlined may not depend on what else is in the unit
    target_compile_options(${name} PRIVATE --param=inline-unit-growth=1000 --param=large-function-growth=1000)
  endif()
  set_target_properties(${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)
  axode_precompile(${name} ${first})
endfunction()

# axode_instantiate(<group> <name> <definitions> <source>...): such objects, compiled once.
function(axode_instantiate group name definitions)
  axode_add_instances(${group} ${name} axode_often_included "${definitions}" ${ARGN})
endfunction()

# axode_instantiate_for_sets(<group> <name> <definitions> <source>...): the same, compiled for each
# instruction set. The objects of the first set have the plain name.
function(axode_instantiate_for_sets group name definitions)
  axode_instantiate(${group} ${name} "${definitions}" ${ARGN})
  if(NOT ARGN OR NOT AXODE_INSTRUCTION_SETS)
    return()
  endif()
  axode_mark_entries(${name} ${group} x86-64)
  foreach(set IN LISTS axode_sets)
    if(set STREQUAL x86-64)
      continue()
    endif()
    axode_add_instances(${group}_${set} ${name}_${set} axode_largest_footprint_${set} "${definitions}" ${ARGN})
    axode_mark_entries(${name}_${set} ${group} ${set})
  endforeach()
endfunction()

# axode_prefer_short_vectors(<name>): makes the compiler use at most 256 bits in the objects <name> for
# x86-64-v4, except where the source asks for more. Recursions over bodies in plain numbers write vectors one number
# at a time. When they are then copied in registers of 512 bits, the processor waits for all these numbers.
function(axode_prefer_short_vectors name)
  if(TARGET ${name}_x86-64-v4)
    target_compile_options(${name}_x86-64-v4 PRIVATE -mprefer-vector-width=256)
    set_target_properties(${name}_x86-64-v4 PROPERTIES DISABLE_PRECOMPILE_HEADERS ON)
  endif()
endfunction()

# axode_add_group(<library> <group>): adds the objects of a group to a library.
function(axode_add_group library group)
  get_property(objects GLOBAL PROPERTY axode_objects_of_${group})
  axode_choose_at_load(${library} ${group} objects)
  foreach(name IN LISTS objects)
    target_sources(${library} PRIVATE $<TARGET_OBJECTS:${name}>)
  endforeach()
endfunction()

# The first objects of the library and of each set.
axode_add_instances(to_dynamics_double axode_often_included axode_often_included "" workspace/workspace)
axode_instantiate_for_sets(to_dynamics_double axode_largest_footprint "" workspace/largest_footprint)

# This library is compiled in two parts, because the demo needs only the first one, in double.
set(floors_to_dynamics lie scalar model table recursion fast kinematics dynamics)
set(floors_beyond_dynamics derivatives constraints contact drives integration catalog)
# It instantiates functions of the class that loop_system.cpp instantiates without them.
set_source_files_properties(${PROJECT_SOURCE_DIR}/axode/constraints/loop_system/loop_derivatives.cpp
                            PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
set(instantiated AXODE_PER_SCALAR AXODE_PER_REPRESENTATION AXODE_FAST_PER_REPRESENTATION AXODE_PER_REPRESENTATION_AND_FAST
                 AXODE_ROWS AXODE_IN_DOUBLE)

# axode_add_part(<part>): adds the groups <part>_double and <part>_float, with
# the objects of these floors. In double, the default kernels and the functions
# that do not depend on a representation are compiled for each instruction set.
function(axode_add_part part)
  set(sources)
  foreach(floor IN LISTS floors_${part})
    file(GLOB_RECURSE more CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/axode/${floor}/*.cpp)
    list(APPEND sources ${more})
  endforeach()
  foreach(source IN LISTS ${instantiated})
    list(REMOVE_ITEM sources ${PROJECT_SOURCE_DIR}/axode/${source}.cpp)
  endforeach()
  axode_add_objects(${part}_double axode_${part} ${sources})
  axode_precompile(axode_${part} axode_to_dynamics)
  axode_unite(axode_${part})

  list(JOIN floors_${part} | floors)
  foreach(list IN LISTS instantiated)
    list(FILTER ${list} INCLUDE REGEX "^(${floors})/")
  endforeach()
  set(of_loops ${AXODE_PER_SCALAR})
  list(FILTER of_loops INCLUDE REGEX "^constraints/")
  list(REMOVE_ITEM AXODE_PER_SCALAR ${of_loops})
  axode_instantiate_for_sets(${part}_double axode_${part}_in_double "" ${AXODE_IN_DOUBLE})
  axode_instantiate_for_sets(${part}_double axode_${part}_loops_double AXODE_T=double ${of_loops})
  axode_instantiate(${part}_float axode_${part}_loops_float AXODE_T=float ${of_loops})
  axode_prefer_short_vectors(axode_${part}_in_double)
  axode_prefer_short_vectors(axode_${part}_loops_double)
  set(instantiate_double axode_instantiate_for_sets)
  set(instantiate_float axode_instantiate)
  foreach(T double float)
    set(group ${part}_${T})
    set(name axode_${part})
    cmake_language(CALL ${instantiate_${T}} ${group} ${name}_${T} AXODE_T=${T} ${AXODE_PER_SCALAR})
    cmake_language(CALL ${instantiate_${T}} ${group} ${name}_Fast_${T} "AXODE_REP=Fast;AXODE_T=${T}"
                   ${AXODE_PER_REPRESENTATION_AND_FAST})
    axode_instantiate(${group} ${name}_rows_Fast_${T} "AXODE_REP=Fast;AXODE_T=${T}" ${AXODE_ROWS})
    foreach(REP BodyFixed Spatial Hybrid Mixed)
      set(definitions "AXODE_REP=${REP};AXODE_T=${T}")
      cmake_language(CALL ${instantiate_${T}} ${group} ${name}_motion_${REP}_${T} "${definitions}"
                     ${AXODE_FAST_PER_REPRESENTATION})
      axode_instantiate(${group} ${name}_${REP}_${T} "${definitions}" ${AXODE_PER_REPRESENTATION}
                        ${AXODE_PER_REPRESENTATION_AND_FAST} ${AXODE_ROWS})
    endforeach()
  endforeach()
endfunction()
axode_add_part(to_dynamics)
axode_add_part(beyond_dynamics)

# Many states at once.
axode_instantiate_for_sets(batch axode_batch_double AXODE_T=double batch/kernels)
axode_instantiate_for_sets(batch axode_batch_float AXODE_T=float batch/kernels)
find_package(TBB REQUIRED)
axode_add_library(axode_batch batch)
file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/axode/batch/*.cpp)
list(REMOVE_ITEM sources ${PROJECT_SOURCE_DIR}/axode/batch/kernels.cpp)
target_sources(axode_batch PRIVATE ${sources})
axode_unite(axode_batch)
target_link_libraries(axode_batch PUBLIC axode::axode PRIVATE TBB::tbb)

foreach(group IN ITEMS to_dynamics_double beyond_dynamics_double)
  axode_add_group(axode_core ${group})
endforeach()
foreach(group IN ITEMS to_dynamics_float beyond_dynamics_float)
  axode_add_group(axode_float ${group})
endforeach()
axode_add_group(axode_batch batch)

axode_add_library(axode_codegen codegen)
file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/axode/codegen/*.cpp)
target_sources(axode_codegen PRIVATE ${sources})
axode_unite(axode_codegen)
axode_optimise_little(axode_codegen)
target_link_libraries(axode_codegen PUBLIC axode_batch PRIVATE ${CMAKE_DL_LIBS})
target_compile_definitions(axode_codegen PRIVATE AXODE_VERSION="${PROJECT_VERSION}")

axode_add_library(axode_io io)
file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/axode/io/*.cpp)
axode_add_objects(io axode_files ${sources})
axode_unite(axode_files)
axode_optimise_little(axode_files)
target_link_libraries(axode_files PRIVATE tinyxml2::tinyxml2)
axode_add_group(axode_io io)
target_link_libraries(axode_io PUBLIC $<BUILD_INTERFACE:axode_core> $<INSTALL_INTERFACE:axode::axode> PRIVATE tinyxml2::tinyxml2)

# The readers and the first part of the library, in double and for x86-64 only: the
# demo and the tests of models and files need no more, and do not wait for the rest.
add_library(axode_first_part STATIC EXCLUDE_FROM_ALL)
target_compile_features(axode_first_part PUBLIC cxx_std_20)
target_include_directories(axode_first_part PUBLIC ${PROJECT_SOURCE_DIR})
target_link_libraries(axode_first_part PUBLIC Eigen3::Eigen tinyxml2::tinyxml2)
get_property(first_part GLOBAL PROPERTY axode_objects_of_to_dynamics_double)
foreach(objects IN ITEMS axode_files ${first_part})
  target_sources(axode_first_part PRIVATE $<TARGET_OBJECTS:${objects}>)
endforeach()
set_target_properties(axode_first_part PROPERTIES LINKER_LANGUAGE CXX)

find_package(nlohmann_json REQUIRED)
find_package(Qhull REQUIRED)
axode_add_library(axode_view view)
file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/axode/view/*.cpp)
target_sources(axode_view PRIVATE ${sources})
axode_unite(axode_view)
axode_optimise_little(axode_view)
target_link_libraries(
  axode_view PUBLIC $<BUILD_INTERFACE:axode_core> $<INSTALL_INTERFACE:axode::axode>
  PRIVATE tinyxml2::tinyxml2 Qhull::qhull_r $<BUILD_INTERFACE:nlohmann_json::nlohmann_json>)

# Mechanisms as FMUs. axode_fmu.so is the binary of every FMU: it contains the parts of the library that it
# needs, and exports the functions of FMI alone. With shared libraries it could not contain them.
axode_add_library(axode_fmi fmi)
file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/axode/fmi/*.cpp)
set(binary ${PROJECT_SOURCE_DIR}/axode/fmi/binary)
set(entries)
foreach(name component.hpp fmi2.cpp fmi3.cpp exported.map README.md)
  file(READ ${binary}/${name} text)
  string(APPEND entries "    {\"${name}\", R\"text(${text})text\"},\n")
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${binary}/${name})
endforeach()
configure_file(${PROJECT_SOURCE_DIR}/axode/fmi/sources.cpp.in ${PROJECT_BINARY_DIR}/fmi_sources.cpp @ONLY)
target_sources(axode_fmi PRIVATE ${sources} ${PROJECT_BINARY_DIR}/fmi_sources.cpp)
axode_unite(axode_fmi)
axode_optimise_little(axode_fmi)
target_link_libraries(axode_fmi PUBLIC $<BUILD_INTERFACE:axode_io> $<INSTALL_INTERFACE:axode::io> PRIVATE tinyxml2::tinyxml2)
set(AXODE_FMU "")
if(NOT BUILD_SHARED_LIBS)
  set(AXODE_FMU ${PROJECT_BINARY_DIR}/axode_fmu.so)
  add_library(axode_fmu MODULE ${binary}/fmi2.cpp ${binary}/fmi3.cpp)
  axode_compile_options(axode_fmu)
  axode_optimise_little(axode_fmu)
  target_include_directories(axode_fmu PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(axode_fmu PRIVATE axode_fmi)
  target_link_options(axode_fmu PRIVATE -Wl,--version-script=${binary}/exported.map -Wl,--as-needed $<$<CONFIG:Release>:-s>)
  if(NOT AXODE_SANITIZE)
    target_link_options(axode_fmu PRIVATE -static-libstdc++ -static-libgcc)
  endif()
  set_target_properties(axode_fmu PROPERTIES PREFIX "" SUFFIX ".so" LINK_DEPENDS ${binary}/exported.map
                                             LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})
endif()

# Exports the libraries for another build that uses them as they are, see AXODE_LIBRARIES.
export(TARGETS axode_core axode_float axode_axode axode_batch axode_codegen axode_io axode_view axode_fmi NAMESPACE axode:: FILE ${PROJECT_BINARY_DIR}/axode-built.cmake)
