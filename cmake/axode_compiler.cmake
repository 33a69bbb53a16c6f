# The options with which every target of the project is compiled.

if(PROJECT_IS_TOP_LEVEL)
  set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
  if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
    set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
  endif()
  find_program(AXODE_CCACHE ccache)
  if(AXODE_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
    # Paths count as relative, so that what one build folder has compiled serves the others; precompiled
    # headers are cached as the manual of ccache asks.
    set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1
                                    CCACHE_SLOPPINESS=pch_defines,time_macros ${AXODE_CCACHE})
    if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
      add_compile_options(-fpch-preprocess)
    elseif(CMAKE_CXX_COMPILER_ID MATCHES Clang)
      add_compile_options("SHELL:-Xclang -fno-pch-timestamp")
    endif()
  endif()
endif()

# Warnings, target architecture and sanitizers. They apply to the targets of the project only, and are not
# passed on to projects that link to it.
function(axode_compile_options target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
                                           -Wno-missing-field-initializers)
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    # GCC 12 sees overlaps in std::string (GCC bug 105329). It takes a twentieth less time if it collects garbage
    # only beyond 1 GB of memory, for at most 0.3 GB more.
    target_compile_options(${target} PRIVATE -Wno-restrict --param=ggc-min-heapsize=1000000)
  endif()
  # IEEE arithmetic is kept (no -ffast-math): these two only say that nobody reads errno or traps after sqrt.
  target_compile_options(${target} PRIVATE -fno-math-errno -fno-trapping-math)
  # Vectors of our own never cross the library's boundary, where their calling convention would matter.
  target_compile_options(${target} PRIVATE -Wno-psabi)
  if(CMAKE_CXX_COMPILER_ID MATCHES Clang)  # as GCC does: a product and a sum may become one instruction
    target_compile_options(${target} PRIVATE -ffp-contract=fast)
  endif()
  # Position-independent code may still be inlined: nobody replaces our functions at load time.
  target_compile_options(${target} PRIVATE -fno-semantic-interposition)
  if(AXODE_WERROR)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
  if(AXODE_NATIVE)
    target_compile_options(${target} PRIVATE -march=native -mprefer-vector-width=512)
    if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
      # GCC warns about its own AVX-512 header (GCC bug 105593), and sees AVX-512 loads of Eigen's leave their
      # arrays in branches that are never taken.
      target_compile_options(${target} PRIVATE -Wno-maybe-uninitialized -Wno-uninitialized -Wno-array-bounds
                                               -Wno-stringop-overread -Wno-stringop-overflow)
    endif()
  endif()
  if(AXODE_SANITIZE)
    target_compile_options(${target} PRIVATE -fsanitize=${AXODE_SANITIZE} -fno-sanitize-recover=all
                                             -fno-omit-frame-pointer)
    target_compile_definitions(${target} PRIVATE _GLIBCXX_ASSERTIONS)
    target_link_options(${target} PRIVATE -fsanitize=${AXODE_SANITIZE})
  endif()
endfunction()
