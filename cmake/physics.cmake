# What the physics are built with, beyond the bus: HDF5, deal.II, one precompiled header for all code with deal.II.

add_library(heartbus_hdf5 INTERFACE)
target_include_directories(heartbus_hdf5 SYSTEM INTERFACE /usr/include/hdf5/openmpi)
target_link_libraries(heartbus_hdf5 INTERFACE hdf5_openmpi MPI::MPI_C)
target_link_directories(heartbus_hdf5 INTERFACE /usr/lib/${CMAKE_LIBRARY_ARCHITECTURE})

add_library(heartbus_dealii INTERFACE)
target_include_directories(heartbus_dealii SYSTEM INTERFACE ${DEAL_II_INCLUDE_DIRS})
# deal.II's headers call into the libraries behind it (Trilinos, TBB, p4est); let the linker find them through deal.II.
target_link_options(heartbus_dealii INTERFACE -Wl,--copy-dt-needed-entries)
if(CMAKE_BUILD_TYPE STREQUAL "Debug")
  set(dealii ${DEAL_II_TARGET_DEBUG})
  target_compile_definitions(heartbus_dealii INTERFACE DEBUG BOOST_NO_AUTO_PTR)
else()
  set(dealii ${DEAL_II_TARGET_RELEASE})
  target_compile_definitions(heartbus_dealii INTERFACE BOOST_NO_AUTO_PTR)
endif()
target_link_libraries(heartbus_dealii INTERFACE ${dealii})

# Nobody here uses what deal.II has for CAD (OpenCASCADE), nor Gmsh's own functions, nor Assimp, but each rank would read them at
# its start, with all that they need: docs/decisions/018-what-is-not-loaded.md.
include(GNUInstallDirs)
find_package(Python3 REQUIRED COMPONENTS Interpreter)
set(not_loaded ${CMAKE_INSTALL_LIBDIR}/heartbus)
find_library(HEARTBUS_DEALII NAMES ${dealii} HINTS ${DEAL_II_PATH}/${DEAL_II_LIBRARY_RELDIR} REQUIRED)
mark_as_advanced(HEARTBUS_DEALII)
execute_process(COMMAND ${Python3_EXECUTABLE} ${CMAKE_SOURCE_DIR}/cmake/empty_libraries.py ${CMAKE_C_COMPILER}
  ${HEARTBUS_DEALII} ${PROJECT_BINARY_DIR}/${not_loaded} libTK libgmsh libassimp OUTPUT_VARIABLE empty_libraries
  COMMAND_ERROR_IS_FATAL ANY)
if(empty_libraries)
  # One item, so that they stay behind deal.II, among whose symbols the loader looks most often.
  target_link_libraries(heartbus_dealii INTERFACE
    "-Wl,--push-state,--no-as-needed,${empty_libraries},--pop-state,--allow-shlib-undefined")
  list(APPEND CMAKE_BUILD_RPATH "\$ORIGIN/../${not_loaded}")
  list(APPEND CMAKE_INSTALL_RPATH "\$ORIGIN/../${not_loaded}")
  install(DIRECTORY ${PROJECT_BINARY_DIR}/${not_loaded} DESTINATION ${CMAKE_INSTALL_LIBDIR} USE_SOURCE_PERMISSIONS)
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/${not_loaded})
endif()

add_library(heartbus_pch OBJECT ${CMAKE_SOURCE_DIR}/cmake/pch.cpp)
target_link_libraries(heartbus_pch PUBLIC heartbus_options heartbus_dealii MPI::MPI_CXX)
target_precompile_headers(heartbus_pch PRIVATE ${CMAKE_SOURCE_DIR}/cmake/pch.h)
# What ccache takes for the content of the precompiled header: the compiler, its flags, all headers of deal.II, and the
# versions of what is below it. So nobody reads the 800 MB once for each file, and all build folders share what is compiled.
set(pch_inputs ${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION} ${CMAKE_BUILD_TYPE} ${CMAKE_CXX_FLAGS}
    ${CMAKE_CXX_FLAGS_RELEASE} ${CMAKE_CXX_FLAGS_DEBUG})
list(GET DEAL_II_INCLUDE_DIRS 0 dealii_headers)
file(GLOB_RECURSE pch_headers ${dealii_headers}/deal.II/*.h)
list(APPEND pch_headers ${CMAKE_SOURCE_DIR}/cmake/pch.h ${dealii_headers}/trilinos/Trilinos_version.h
     ${dealii_headers}/boost/version.hpp ${MPI_CXX_HEADER_DIR}/mpi.h)
foreach(header ${pch_headers})
  if(EXISTS ${header})
    file(SHA256 ${header} sum)
    list(APPEND pch_inputs ${sum})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${header})
  endif()
endforeach()
string(SHA256 pch_inputs "${pch_inputs}")
file(WRITE ${CMAKE_BINARY_DIR}/CMakeFiles/heartbus_pch.dir/cmake_pch.hxx.gch.sum "${pch_inputs}")
