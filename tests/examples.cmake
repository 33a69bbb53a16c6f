# Every example runs to its end without an error.
get_property(targets DIRECTORY ${PROJECT_SOURCE_DIR}/examples PROPERTY BUILDSYSTEM_TARGETS)
foreach(target IN LISTS targets)
  get_target_property(name ${target} OUTPUT_NAME)
  add_test(NAME Examples.${name} COMMAND ${target} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}/examples)
  set_tests_properties(Examples.${name} PROPERTIES LABELS examples TIMEOUT 120)
endforeach()
