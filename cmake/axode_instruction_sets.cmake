# Code for several instruction sets in one library. Sources of kernels are compiled for x86-64, x86-64-v3 and
# x86-64-v4, or for x86-64 and the best one that this processor has. They mark by AXODE_ENTRY the functions that other
# code calls (axode/scalar/instruction_set.hpp).
# choose_at_load.cmake joins the objects of a group to one object, in which only these functions are visible:
# each is a jump to the code of the set that was chosen when the library was loaded. All other functions of
# the sets are local, so that no linker can use a template that was compiled for AVX-512 in other code.
set(possible OFF)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|amd64|AMD64)$" AND CMAKE_EXECUTABLE_FORMAT STREQUAL ELF AND CMAKE_SIZEOF_VOID_P EQUAL 8)
  find_program(AXODE_LD NAMES ld.bfd ld)
  execute_process(COMMAND ${AXODE_LD} --help OUTPUT_VARIABLE help ERROR_QUIET)
  if(help MATCHES "force-group-allocation" AND CMAKE_OBJCOPY AND CMAKE_READELF)
    set(possible ON)
  else()
    message(STATUS "axode: kernels are compiled for one instruction set only, as GNU ld, objcopy and readelf are not there")
  endif()
endif()
set(wanted ${possible})
if(AXODE_NATIVE OR AXODE_SANITIZE OR CMAKE_BUILD_TYPE STREQUAL Debug)
  set(wanted OFF)
endif()
set(AXODE_INSTRUCTION_SETS ${wanted} CACHE STRING
    "Compile kernels for x86-64, x86-64-v3 and x86-64-v4 (ON), or for x86-64 and the best one of this processor (host); the library chooses when it is loaded")
string(TOUPPER "${AXODE_INSTRUCTION_SETS}" word)
if(NOT AXODE_INSTRUCTION_SETS STREQUAL host AND NOT word MATCHES "^(ON|OFF|TRUE|FALSE|YES|NO|Y|N|1|0)$")
  message(FATAL_ERROR "AXODE_INSTRUCTION_SETS is \"${AXODE_INSTRUCTION_SETS}\"; it must be ON, OFF or host")
endif()
if(AXODE_INSTRUCTION_SETS STREQUAL host AND NOT possible)
  set(AXODE_INSTRUCTION_SETS OFF)
endif()
if(AXODE_INSTRUCTION_SETS AND NOT possible)
  message(FATAL_ERROR "AXODE_INSTRUCTION_SETS needs x86-64, ELF, GNU ld, objcopy and readelf; configure with -DAXODE_INSTRUCTION_SETS=OFF")
endif()

set(all_sets x86-64 x86-64-v3 x86-64-v4)
set(axode_sets ${all_sets})
if(AXODE_INSTRUCTION_SETS STREQUAL host)
  execute_process(COMMAND ${CMAKE_CXX_COMPILER} -march=native -dM -E -x c++ /dev/null OUTPUT_VARIABLE has
                  COMMAND_ERROR_IS_FATAL ANY)
  set(axode_sets x86-64)
  if(has MATCHES "__AVX512VL__")
    list(APPEND axode_sets x86-64-v4)
  elseif(has MATCHES "__AVX2__")
    list(APPEND axode_sets x86-64-v3)
  endif()
endif()
if(NOT AXODE_INSTRUCTION_SETS)
  string(TOLOWER "${CMAKE_SYSTEM_PROCESSOR}" only_set)
  if(AXODE_NATIVE)
    set(only_set native)
  elseif(only_set MATCHES "^(x86_64|amd64)$")
    set(only_set x86-64)
  endif()
  set(of_sets "AXODE_ONLY_SET=\"${only_set}\"")
else()
  set(numbers)
  foreach(set IN LISTS axode_sets)
    list(FIND all_sets ${set} number)
    list(APPEND numbers ${number})
  endforeach()
  list(JOIN numbers , numbers)
  set(of_sets AXODE_SETS=${numbers})
endif()
set_source_files_properties(${PROJECT_SOURCE_DIR}/axode/scalar/instruction_set.cpp PROPERTIES COMPILE_DEFINITIONS "${of_sets}")

# The order of instructions suits the first processors with a set: with GCC's generic order, forward dynamics
# takes a fifth longer on later processors, too.
set(options_of_x86-64)
set(options_of_x86-64-v3 -march=x86-64-v3 -mtune=haswell)
set(options_of_x86-64-v4 -march=x86-64-v4 -mtune=skylake-avx512 -mprefer-vector-width=512)
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)  # in its own AVX-512 header (GCC bug 105593)
  list(APPEND options_of_x86-64-v4 -Wno-maybe-uninitialized -Wno-uninitialized)
endif()

# Eigen allocates and aligns arrays in all sets as for x86-64, because code of one
# set uses and frees arrays of another. It leaves vectors to the compiler: with its
# own for AVX, the order of a sum depends on where such an array lies in memory.
set(as_for_x86-64 -DEIGEN_DONT_VECTORIZE -DEIGEN_MAX_ALIGN_BYTES=16 -DEIGEN_MAX_STATIC_ALIGN_BYTES=16)
list(APPEND options_of_x86-64-v3 ${as_for_x86-64})
list(APPEND options_of_x86-64-v4 ${as_for_x86-64})

# axode_mark_entries(<objects> <group> <set>): compiles objects of a group for an instruction set.
function(axode_mark_entries objects group set)
  target_compile_definitions(${objects} PRIVATE AXODE_MARK_ENTRIES)
  target_compile_options(${objects} PRIVATE ${options_of_${set}} -fno-lto)
  set_property(GLOBAL APPEND PROPERTY axode_objects_of_${group}_for_${set} ${objects})
endfunction()

# axode_choose_at_load(<library> <group> <list>): adds the joined object of a group to a library, and removes
# the objects that it contains from the named list of objects.
function(axode_choose_at_load library group list)
  get_property(in_sets GLOBAL PROPERTY axode_objects_of_${group}_for_x86-64)
  if(NOT in_sets)
    return()
  endif()
  list(REMOVE_ITEM ${list} ${in_sets})
  set(${list} ${${list}} PARENT_SCOPE)
  set(folder ${PROJECT_BINARY_DIR}/instruction_sets)
  set(files)
  foreach(set IN LISTS axode_sets)
    get_property(in_set GLOBAL PROPERTY axode_objects_of_${group}_for_${set})
    list(TRANSFORM in_set REPLACE "(.+)" "$<TARGET_OBJECTS:\\1>")
    list(APPEND files ${in_set})
    file(GENERATE OUTPUT ${folder}/${group}_${set}.txt CONTENT "${in_set}")
  endforeach()
  set(joined ${folder}/${group}.o)
  set(script ${PROJECT_SOURCE_DIR}/cmake/choose_at_load.cmake)
  add_custom_command(
    OUTPUT ${joined}
    COMMAND ${CMAKE_COMMAND} -Dgroup=${group} -Dfolder=${folder} -Dcompiler=${CMAKE_CXX_COMPILER} -Dld=${AXODE_LD}
            -Dobjcopy=${CMAKE_OBJCOPY} -Dreadelf=${CMAKE_READELF} "-Dsets=${axode_sets}" -P ${script}
    DEPENDS ${files} ${script}
    COMMENT "Joining the code of ${group} for all instruction sets"
    VERBATIM)
  set_source_files_properties(${joined} PROPERTIES EXTERNAL_OBJECT ON GENERATED ON)
  target_sources(${library} PRIVATE ${joined})
endfunction()
