# The target `reference`: the C reference as HTML, from the public headers, where Doxygen is installed
# (Debian: apt-get install doxygen). A warning fails it. SPDX-License-Identifier: Apache-2.0
find_program(THRUM_DOXYGEN doxygen)
if(THRUM_DOXYGEN)
  configure_file(${CMAKE_CURRENT_SOURCE_DIR}/docs/Doxyfile.in ${CMAKE_BINARY_DIR}/reference/Doxyfile @ONLY)
  add_custom_target(reference
    COMMAND ${THRUM_DOXYGEN} ${CMAKE_BINARY_DIR}/reference/Doxyfile
    COMMAND ${CMAKE_COMMAND} -E echo "${CMAKE_BINARY_DIR}/reference/html/index.html"
    COMMENT "The C reference" VERBATIM)
endif()
