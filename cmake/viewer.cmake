# The viewer in the browser: the target `viewer` makes viewer.html, once for all builds. It wants
# node, npm and a clang for WebAssembly, and says which are missing; nothing else needs it.
# SPDX-License-Identifier: Apache-2.0
option(THRUM_BUILD_VIEWER "Build the viewer with everything else, and test it" OFF)
# another build's page will do
set(THRUM_VIEWER_PAGE ${CMAKE_BINARY_DIR}/viewer/viewer.html CACHE FILEPATH "The viewer's page")

file(GLOB THRUM_VIEWER_SOURCES CONFIGURE_DEPENDS viewer/*.* viewer/src/* javascript/compile.mjs javascript/*.[ch] javascript/src/* gradient/*.[ch] scene/*.[ch] core/*/* runtime/*/* contact/*
  include/thrum/*.h)
add_custom_command(OUTPUT ${CMAKE_BINARY_DIR}/viewer/viewer.html
  COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/cmake/node_package.sh viewer ${CMAKE_BINARY_DIR}/viewer
  DEPENDS ${THRUM_VIEWER_SOURCES} COMMENT "Building the viewer" VERBATIM)
if(THRUM_BUILD_VIEWER)
  set(with_all ALL)
endif()
add_custom_target(viewer ${with_all} DEPENDS ${CMAKE_BINARY_DIR}/viewer/viewer.html)
if(THRUM_SOURCE_FALLBACK)
  set_property(SOURCE app/view/viewer_page.c APPEND PROPERTY COMPILE_DEFINITIONS
    THRUM_BUILT_VIEWER="${THRUM_VIEWER_PAGE}")
endif()
# the npm package, in javascript/dist
add_custom_target(javascript COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/cmake/node_package.sh javascript
  COMMENT "Building the npm package" VERBATIM)
install(FILES ${THRUM_VIEWER_PAGE} DESTINATION share/thrum OPTIONAL)
