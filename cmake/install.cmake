# What `cmake --install` puts where: the five libraries, their headers, thrumConfig.cmake, thrum.pc,
# thrum-scene.pc, thrum-response.pc, thrum-gradient.pc, thrum-accelerator.pc, the licence and the examples.
# SPDX-License-Identifier: Apache-2.0
set(THRUM_CMAKE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/thrum)

install(TARGETS thrum thrum_scene thrum_response thrum_gradient thrum_accelerator EXPORT thrumTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
  RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY include/thrum DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY examples/ DESTINATION ${CMAKE_INSTALL_DOCDIR}/examples
  FILES_MATCHING PATTERN "*.[ch]" PATTERN "CMakeLists.txt" PATTERN "bytes.cmake" PATTERN "*.cs" PATTERN "*.py" PATTERN "*.ipynb"
  PATTERN "*.stl" PATTERN "jobs/*.sh" PATTERN "scenes" EXCLUDE)
install(EXPORT thrumTargets NAMESPACE thrum:: DESTINATION ${THRUM_CMAKE_DIR})

configure_package_config_file(cmake/thrumConfig.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/thrumConfig.cmake
  INSTALL_DESTINATION ${THRUM_CMAKE_DIR})
# before 1.0 a minor version may change the interface (docs/versioning.md)
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/thrumConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/thrumConfig.cmake
  ${CMAKE_CURRENT_BINARY_DIR}/thrumConfigVersion.cmake DESTINATION ${THRUM_CMAKE_DIR})

# the .pc file finds its prefix from where it lies, so `cmake --install --prefix` may change it
if(IS_ABSOLUTE ${CMAKE_INSTALL_LIBDIR} OR IS_ABSOLUTE ${CMAKE_INSTALL_INCLUDEDIR})
  set(THRUM_PC_PREFIX ${CMAKE_INSTALL_PREFIX})
  set(THRUM_PC_LIBDIR ${CMAKE_INSTALL_FULL_LIBDIR})
  set(THRUM_PC_INCLUDEDIR ${CMAKE_INSTALL_FULL_INCLUDEDIR})
else()
  file(RELATIVE_PATH THRUM_PC_UP "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")
  string(REGEX REPLACE "/$" "" THRUM_PC_UP "${THRUM_PC_UP}")
  set(THRUM_PC_PREFIX "\${pcfiledir}/${THRUM_PC_UP}")
  set(THRUM_PC_LIBDIR "\${prefix}/${CMAKE_INSTALL_LIBDIR}")
  set(THRUM_PC_INCLUDEDIR "\${prefix}/${CMAKE_INSTALL_INCLUDEDIR}")
endif()
# a static library cannot name what it needs itself; a shared one can, and says it for --static alone
if(BUILD_SHARED_LIBS)
  set(THRUM_PC_LIBS "")
  set(THRUM_PC_LIBS_PRIVATE " -lm")
else()
  set(THRUM_PC_LIBS " -lm")
  set(THRUM_PC_LIBS_PRIVATE "")
endif()
foreach(name thrum thrum-scene thrum-response thrum-gradient thrum-accelerator)
  configure_file(cmake/${name}.pc.in ${CMAKE_CURRENT_BINARY_DIR}/${name}.pc @ONLY)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endforeach()
