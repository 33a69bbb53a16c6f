# The page of the viewer, AXODE_PAGE, without a scene in it. npm builds it in a
# folder of the build tree, so that nothing is written beside the sources. The
# target axode_viewer is there in any case, the page where AXODE_VIEWER is ON.
set(AXODE_PAGE "")
if(AXODE_LIBRARIES)  # what that build has made
  set(AXODE_PAGE ${AXODE_LIBRARIES}/viewer/dist/page.html)
  add_custom_target(axode_viewer)
  return()
endif()

find_program(AXODE_NPM npm)
set(wanted OFF)
if(AXODE_NPM AND PROJECT_IS_TOP_LEVEL)
  set(wanted ON)
endif()
option(AXODE_VIEWER "Build the page of the viewer, with npm" ${wanted})
if(NOT AXODE_VIEWER)
  message(STATUS "axode: no viewer (AXODE_VIEWER is OFF, which it is by default where there is no npm)")
  add_custom_target(axode_viewer)
  return()
endif()
if(NOT AXODE_NPM)
  message(FATAL_ERROR "AXODE_VIEWER is ON, and there is no npm; install it, or configure with -DAXODE_VIEWER=OFF")
endif()

set(source ${PROJECT_SOURCE_DIR}/viewer)
set(AXODE_VIEWER_FOLDER ${PROJECT_BINARY_DIR}/viewer)
set(AXODE_PAGE ${AXODE_VIEWER_FOLDER}/dist/page.html)
set(packages ${source}/package.json ${source}/package-lock.json ${source}/.npmrc)
file(GLOB settings CONFIGURE_DEPENDS ${source}/*.html ${source}/*.js ${source}/tsconfig.json)
file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${source}/src/* ${source}/test/*)

file(MAKE_DIRECTORY ${AXODE_VIEWER_FOLDER})

# `npm install` takes the locked versions, as `npm ci` does, and also packages that only some platforms need.
set(fetched ${AXODE_VIEWER_FOLDER}/node_modules/.package-lock.json)
set(or_else "{ echo 'The viewer could not be built; -DAXODE_VIEWER=OFF builds axode without it.' >&2; exit 1; }")
add_custom_command(
  OUTPUT ${fetched}
  DEPENDS ${packages}
  COMMAND ${CMAKE_COMMAND} -E copy ${packages} .
  COMMAND sh -c "'${AXODE_NPM}' install --no-audit --no-fund --loglevel=error || ${or_else}"
  COMMAND ${CMAKE_COMMAND} -E touch ${fetched}
  WORKING_DIRECTORY ${AXODE_VIEWER_FOLDER}
  COMMENT "Fetching the packages of the viewer"
  VERBATIM)
add_custom_command(
  OUTPUT ${AXODE_PAGE}
  DEPENDS ${fetched} ${settings} ${sources}
  COMMAND ${CMAKE_COMMAND} -E rm -rf src test
  COMMAND ${CMAKE_COMMAND} -E copy_directory ${source}/src src
  COMMAND ${CMAKE_COMMAND} -E copy_directory ${source}/test test
  COMMAND ${CMAKE_COMMAND} -E copy ${settings} .
  COMMAND sh -c "'${AXODE_NPM}' run --silent build -- --logLevel warn || ${or_else}"
  COMMAND ${CMAKE_COMMAND} -E touch ${AXODE_PAGE}
  WORKING_DIRECTORY ${AXODE_VIEWER_FOLDER}
  COMMENT "Building the page of the viewer"
  VERBATIM)
add_custom_target(axode_viewer ALL DEPENDS ${AXODE_PAGE})
