# Joins the objects of a group that are compiled for several
# instruction sets, see axode_instruction_sets.cmake:
#   cmake -Dgroup=... -Dfolder=... -Dcompiler=... -Dld=... -Dobjcopy=... -Dreadelf=... -Dsets=... -P choose_at_load.cmake
# reads the names of the objects for each set from <folder>/<group>_<set>.txt and writes <folder>/<group>.o.
cmake_minimum_required(VERSION 3.25)

function(run)
  execute_process(COMMAND ${ARGN} OUTPUT_VARIABLE output COMMAND_ERROR_IS_FATAL ANY)
  set(output "${output}" PARENT_SCOPE)
endfunction()
function(assemble name source)
  file(WRITE ${name}.s "${source}\t.section .note.GNU-stack,\"\",@progbits\n")
  run(${compiler} -c ${name}.s -o ${name}.o)
endfunction()

# All objects of a set become one, without groups of sections that a linker would compare with those of other
# objects. Entries are the functions with protected visibility, without lambdas in them and templates of these
# lambdas, which inherit the visibility. Members that are templates of their own may be inlined in one set and
# not in another: what all sets have is an entry.
foreach(set IN LISTS sets)
  set(name ${folder}/${group}_${set})
  file(READ ${name}.txt objects)
  list(FILTER objects INCLUDE REGEX "\\.o$")  # CMake lists precompiled headers among the objects
  run(${ld} -r --force-group-allocation -o ${name}_linked.o ${objects})
  run(${readelf} --syms --wide ${name}_linked.o)
  string(REGEX MATCHALL "FUNC +(GLOBAL|WEAK) +PROTECTED +[0-9]+ [^ \n]+" functions "${output}")
  list(TRANSFORM functions REPLACE ".* " "")
  # Variables in templates become weak, because objcopy makes
  # no symbols local that GCC declares unique in a process.
  string(REGEX MATCHALL "OBJECT +UNIQUE +[A-Z]+ +[0-9]+ [^ \n]+" variables "${output}")
  list(TRANSFORM variables REPLACE ".* " "")
  list(JOIN variables "\n" variables)
  file(WRITE ${name}_unique.txt "${variables}\n")
  run(${objcopy} --weaken-symbols=${name}_unique.txt ${name}_linked.o)
  list(FILTER functions EXCLUDE REGEX "^_ZZ|Ul.*E[0-9]*_")
  list(SORT functions)
  if(NOT DEFINED entries)
    set(entries ${functions})
  endif()
  foreach(entry IN LISTS entries)
    if(NOT entry IN_LIST functions)
      list(REMOVE_ITEM entries ${entry})
    endif()
  endforeach()
endforeach()
if(NOT entries)
  message(FATAL_ERROR "the objects of ${group} have no entries; is AXODE_ENTRY missing?")
endif()

# The addresses of the entries. In the object of a set, only this array is visible; the first set also has the
# array of the chosen addresses, which are its own until the library is loaded.
list(JOIN entries "\n\t.quad " addresses)
set(tables)
foreach(set IN LISTS sets)
  set(name ${folder}/${group}_${set})
  string(MAKE_C_IDENTIFIER axode_entries_of_${group}_${set} table)
  set(source "\t.section .data.rel.ro,\"aw\"\n\t.balign 8\n\t.globl ${table}\n${table}:\n\t.quad ${addresses}\n")
  set(visible --keep-global-symbol=${table})
  if(NOT tables)
    set(chosen axode_chosen_entries_of_${group})
    string(APPEND source "\t.data\n\t.balign 8\n\t.globl ${chosen}\n${chosen}:\n\t.quad ${addresses}\n")
    list(APPEND visible --keep-global-symbol=${chosen})
  endif()
  assemble(${name}_table "${source}")
  run(${ld} -r -o ${name}_linked_with_table.o ${name}_linked.o ${name}_table.o)
  run(${objcopy} ${visible} ${name}_linked_with_table.o ${name}.o)
  list(APPEND tables ${table})
endforeach()

# Each entry is a jump to its chosen address. Loading calls
# axode_choose_entries() of instruction_set.cpp before other initialisations.
set(source "\t.text\n")
set(offset 0)
foreach(entry IN LISTS entries)
  string(APPEND source "\t.balign 16\n\t.globl ${entry}\n\t.type ${entry}, @function\n${entry}:\n\tendbr64\n"
                       "\tjmp *${chosen}+${offset}(%rip)\n\t.size ${entry}, .-${entry}\n")
  math(EXPR offset "${offset} + 8")
endforeach()
list(LENGTH entries n)
list(JOIN tables ", " tables)
string(APPEND source "\t.balign 16\nchoose:\n\tendbr64\n\tleaq ${chosen}(%rip), %rdi\n\tleaq tables(%rip), %rsi\n"
                     "\tmovl $${n}, %edx\n\tjmp axode_choose_entries@PLT\n"
                     "\t.section .data.rel.ro,\"aw\"\n\t.balign 8\ntables:\n\t.quad ${tables}\n"
                     "\t.section .init_array.00101,\"aw\",@init_array\n\t.balign 8\n\t.quad choose\n")
assemble(${folder}/${group}_jumps "${source}")
set(parts ${folder}/${group}_jumps.o)
foreach(set IN LISTS sets)
  list(APPEND parts ${folder}/${group}_${set}.o)
endforeach()
run(${ld} -r -o ${folder}/${group}_visible.o ${parts})
list(JOIN entries "\n" names)
file(WRITE ${folder}/${group}_entries.txt "${names}\n")
run(${objcopy} --keep-global-symbols=${folder}/${group}_entries.txt ${folder}/${group}_visible.o ${folder}/${group}.o)
