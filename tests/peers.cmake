# Agreement with other libraries, from Python: every tests/peers/test_*.py is one test. Without the Python
# environment of `make build/venv/tests`, or without the robots' files, it is skipped and says so.
file(GLOB peers CONFIGURE_DEPENDS peers/test_*.py)
foreach(file IN LISTS peers)
  cmake_path(GET file STEM name)
  string(REGEX REPLACE "^test_" "" name ${name})
  add_test(NAME Peers.${name} COMMAND ${AXODE_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/support/run_peer_test.py
                                      ${AXODE_VENV}/bin/python ${file})
  set_tests_properties(
    Peers.${name} PROPERTIES LABELS peers SKIP_RETURN_CODE 77 TIMEOUT 1200
                             ENVIRONMENT "AXODE_COMMAND=$<TARGET_FILE:axode_command>")
endforeach()
