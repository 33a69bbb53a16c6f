# Laws about the source tree itself, and about the installed package.
set(guards ${CMAKE_CURRENT_LIST_DIR})

# Includes follow the floors; every kind is in its table, and new things have their places; no
# machine's paths, no catch-all names; one version; clear messages.
add_test(NAME Guards.IncludeFloors COMMAND ${AXODE_PYTHON} ${guards}/include_floors.py ${PROJECT_SOURCE_DIR})
add_test(NAME Guards.CleanTree COMMAND ${AXODE_PYTHON} ${guards}/clean_tree.py ${PROJECT_SOURCE_DIR})
add_test(NAME Guards.Kinds COMMAND ${AXODE_PYTHON} ${guards}/kinds.py ${PROJECT_SOURCE_DIR})
add_test(NAME Guards.Versions COMMAND ${AXODE_PYTHON} ${guards}/versions.py ${PROJECT_SOURCE_DIR})
add_test(NAME Guards.Messages COMMAND ${AXODE_PYTHON} ${guards}/messages.py ${PROJECT_SOURCE_DIR}
                                      ${PROJECT_BINARY_DIR}/messages.txt)
add_test(NAME Guards.Mutants COMMAND ${AXODE_PYTHON} ${PROJECT_SOURCE_DIR}/tools/mutants.py --check)
set_tests_properties(Guards.IncludeFloors Guards.CleanTree Guards.Kinds Guards.Versions Guards.Messages Guards.Mutants
                     PROPERTIES LABELS guards)

# Code for one instruction set stays out of programs that run without it.
if(AXODE_INSTRUCTION_SETS AND NOT BUILD_SHARED_LIBS)
  list(JOIN axode_sets , sets)
  add_test(NAME Guards.InstructionSets
           COMMAND ${AXODE_PYTHON} ${guards}/instruction_sets.py ${CMAKE_NM} ${CMAKE_OBJDUMP} ${sets}
                   ${PROJECT_BINARY_DIR}/instruction_sets $<TARGET_FILE:axode_core> $<TARGET_FILE:axode_batch>)
  set_tests_properties(Guards.InstructionSets PROPERTIES LABELS guards)
endif()

# What mixes representations or kinds does not compile.
get_target_property(eigen_includes Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
add_test(NAME Guards.MustNotCompile
         COMMAND ${AXODE_PYTHON} ${guards}/must_not_compile.py ${guards}/must_not_compile.cpp ${CMAKE_CXX_COMPILER}
                 -std=c++20 -I${PROJECT_SOURCE_DIR} -isystem ${eigen_includes})
set_tests_properties(Guards.MustNotCompile PROPERTIES LABELS guards)

# Tiny outside programs build and run against the installed tree, found by find_package and by pkg-config.
if(AXODE_INSTALL AND NOT AXODE_SANITIZE)
  set(scratch ${PROJECT_BINARY_DIR}/package)
  set(prefix ${scratch}/prefix)
  set(libraries ${prefix}/${CMAKE_INSTALL_LIBDIR})
  add_test(NAME Package.Install
           COMMAND sh -c "rm -rf '${scratch}' && '${CMAKE_COMMAND}' --install '${PROJECT_BINARY_DIR}' --prefix '${prefix}'")
  add_test(
    NAME Package.FindPackage
    COMMAND
      ${CMAKE_CTEST_COMMAND} --build-and-test ${guards}/consumer ${scratch}/find_package --build-generator
      ${CMAKE_GENERATOR} --build-noclean --build-options -DCMAKE_PREFIX_PATH=${prefix}
      -DCMAKE_CXX_COMPILER=${CMAKE_CXX_COMPILER} -DCMAKE_BUILD_TYPE=Release --test-command sh -c
      "'${scratch}/find_package/consumer' && '${scratch}/find_package/parts/parts'")
  add_test(NAME Package.PkgConfig
           COMMAND ${CMAKE_COMMAND} -E env PKG_CONFIG_PATH=${libraries}/pkgconfig LD_LIBRARY_PATH=${libraries}
                   make -C ${guards}/consumer CXX=${CMAKE_CXX_COMPILER} OUT=${scratch}/pkg_config run)
  set_tests_properties(Package.Install PROPERTIES LABELS package FIXTURES_SETUP installed_tree)
  if(TARGET axode_command)  # with what shells and `man` know about it
    set(share ${prefix}/${CMAKE_INSTALL_DATADIR})
    add_test(NAME Package.Completion
             COMMAND sh -c "grep -q _axode '${share}/bash-completion/completions/axode' && grep -q compdef '${share}/zsh/site-functions/_axode' && grep -q complete '${share}/fish/vendor_completions.d/axode.fish' && grep -q AXODE '${prefix}/${CMAKE_INSTALL_MANDIR}/man1/axode.1'")
    set_tests_properties(Package.Completion PROPERTIES LABELS package FIXTURES_REQUIRED installed_tree)
  endif()
  set_tests_properties(Package.FindPackage Package.PkgConfig
                       PROPERTIES LABELS package FIXTURES_REQUIRED installed_tree TIMEOUT 300)
endif()
