# The Python package (python/README.md): its sources, the declarations for cffi, the types of options, and one shared library of
# the runtime and the scenes, side by side in build/python/thrum, from where it can be imported.
# SPDX-License-Identifier: Apache-2.0
if(TARGET thrum_python_package)
  return()
endif()
set(THRUM_PYTHON_BUILD ${PROJECT_BINARY_DIR}/python)
file(GLOB python_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/python/thrum/*.py
  ${PROJECT_SOURCE_DIR}/python/thrum/py.typed)
file(GLOB public_headers CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/include/thrum/*.h)

add_library(thrum_python_library SHARED $<TARGET_OBJECTS:thrum_objects> $<TARGET_OBJECTS:thrum_contact>
  $<TARGET_OBJECTS:thrum_scene_objects> $<TARGET_OBJECTS:thrum_response_objects>
  $<TARGET_OBJECTS:thrum_gradient_objects>)
target_link_libraries(thrum_python_library PRIVATE thrum_flags m)
target_link_options(thrum_python_library PRIVATE -Wl,-z,defs)
set_target_properties(thrum_python_library PROPERTIES OUTPUT_NAME thrum
  LIBRARY_OUTPUT_DIRECTORY ${THRUM_PYTHON_BUILD}/thrum)

set(declarations ${THRUM_PYTHON_BUILD}/thrum/_declarations.py)
set(keywords ${THRUM_PYTHON_BUILD}/thrum/_keywords.py)
add_custom_command(OUTPUT ${declarations} ${keywords}
  COMMAND ${THRUM_PYTHON} ${PROJECT_SOURCE_DIR}/python/declarations.py
    ${PROJECT_SOURCE_DIR}/include ${CMAKE_C_COMPILER} ${declarations} ${keywords}
  DEPENDS ${PROJECT_SOURCE_DIR}/python/declarations.py ${public_headers})
file(GLOB schemas CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/docs/schema/*.schema.json)
set(options ${THRUM_PYTHON_BUILD}/thrum/_options.py)
add_custom_command(OUTPUT ${options}
  COMMAND ${THRUM_PYTHON} ${PROJECT_SOURCE_DIR}/python/options.py ${PROJECT_SOURCE_DIR}/docs/schema ${options}
  DEPENDS ${PROJECT_SOURCE_DIR}/python/options.py ${schemas})
set(copies)
foreach(source ${python_sources})
  get_filename_component(name ${source} NAME)
  add_custom_command(OUTPUT ${THRUM_PYTHON_BUILD}/thrum/${name}
    COMMAND ${CMAKE_COMMAND} -E copy ${source} ${THRUM_PYTHON_BUILD}/thrum/${name} DEPENDS ${source})
  list(APPEND copies ${THRUM_PYTHON_BUILD}/thrum/${name})
endforeach()
add_custom_target(thrum_python_package ALL DEPENDS ${declarations} ${keywords} ${options} ${copies}
  thrum_python_library)
