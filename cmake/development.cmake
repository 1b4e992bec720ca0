# Targets for those who change the code: `programs` (all but the tests), `format`, `tidy`.

add_custom_target(programs)
get_property(targets DIRECTORY PROPERTY BUILDSYSTEM_TARGETS)
foreach(target ${targets})
  get_target_property(type ${target} TYPE)
  if(type STREQUAL "EXECUTABLE")
    add_dependencies(programs ${target})
  endif()
endforeach()

file(GLOB_RECURSE own_sources CONFIGURE_DEPENDS
  ${CMAKE_SOURCE_DIR}/common/*.cpp ${CMAKE_SOURCE_DIR}/*_solver/*.cpp ${CMAKE_SOURCE_DIR}/coupler/*.cpp ${CMAKE_SOURCE_DIR}/scene/*.cpp)
file(GLOB_RECURSE own_headers CONFIGURE_DEPENDS
  ${CMAKE_SOURCE_DIR}/common/*.h ${CMAKE_SOURCE_DIR}/*_solver/*.h ${CMAKE_SOURCE_DIR}/coupler/*.h ${CMAKE_SOURCE_DIR}/scene/*.h)
file(GLOB_RECURSE own_tests CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/tests/*.cpp ${CMAKE_SOURCE_DIR}/tests/*.h)

add_custom_target(format COMMAND clang-format -i ${own_sources} ${own_headers} ${own_tests} VERBATIM)
add_custom_target(tidy COMMAND run-clang-tidy -quiet -p ${CMAKE_BINARY_DIR} ${own_sources} VERBATIM)
