# axode_instantiate(<target> <template>.cpp.in REPS <representation>... SCALARS <scalar>...)
#
# Adds to <target> one translation unit per (representation, scalar), made from the template by replacing
# @REP@ and @T@. One unit each, because many explicit instantiations in one unit exhaust GCC's inlining
# budget and double the run time of the kernels.
function(axode_instantiate target template)
  cmake_parse_arguments(PARSE_ARGV 2 arg "" "" "REPS;SCALARS")
  cmake_path(ABSOLUTE_PATH template BASE_DIRECTORY ${PROJECT_SOURCE_DIR} NORMALIZE)
  cmake_path(RELATIVE_PATH template BASE_DIRECTORY ${PROJECT_SOURCE_DIR} OUTPUT_VARIABLE name)
  string(REGEX REPLACE "\\.cpp\\.in$" "" name ${name})
  foreach(REP IN LISTS arg_REPS)
    foreach(T IN LISTS arg_SCALARS)
      string(MAKE_C_IDENTIFIER "${REP}_${T}" suffix)
      set(unit ${PROJECT_BINARY_DIR}/generated/${name}_${suffix}.cpp)
      configure_file(${template} ${unit} @ONLY)
      target_sources(${target} PRIVATE ${unit})
    endforeach()
  endforeach()
endfunction()
