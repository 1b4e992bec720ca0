# Targets for those who change the code: `programs` (all but the tests), `format`, `tidy`.

set(programs coupler ep_solver mech_solver ale_solver fluid_solver)
add_custom_target(programs)
foreach(program ${programs})
  if(TARGET ${program})
    add_dependencies(programs ${program})
  endif()
endforeach()

file(GLOB_RECURSE own_sources CONFIGURE_DEPENDS
  ${CMAKE_SOURCE_DIR}/common/*.cpp ${CMAKE_SOURCE_DIR}/*_solver/*.cpp ${CMAKE_SOURCE_DIR}/coupler/*.cpp)
file(GLOB_RECURSE own_headers CONFIGURE_DEPENDS
  ${CMAKE_SOURCE_DIR}/common/*.h ${CMAKE_SOURCE_DIR}/*_solver/*.h ${CMAKE_SOURCE_DIR}/coupler/*.h)
file(GLOB_RECURSE own_tests CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/tests/*.cpp ${CMAKE_SOURCE_DIR}/tests/*.h)

add_custom_target(format COMMAND clang-format -i ${own_sources} ${own_headers} ${own_tests} VERBATIM)
add_custom_target(tidy COMMAND run-clang-tidy -quiet -p ${CMAKE_BINARY_DIR} ${own_sources} VERBATIM)
