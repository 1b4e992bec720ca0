# Helpers of the build: one library per folder, one tiny main per program, one precompiled header for all code with deal.II.

add_library(heartbus_hdf5 INTERFACE)
target_include_directories(heartbus_hdf5 SYSTEM INTERFACE /usr/include/hdf5/openmpi)
target_link_libraries(heartbus_hdf5 INTERFACE hdf5_openmpi MPI::MPI_C)
target_link_directories(heartbus_hdf5 INTERFACE /usr/lib/${CMAKE_LIBRARY_ARCHITECTURE})

add_library(heartbus_options INTERFACE)
target_include_directories(heartbus_options INTERFACE ${CMAKE_SOURCE_DIR})
# psabi: the notes about vector types passed between functions do not concern us, they stay inside one file.
target_compile_options(heartbus_options INTERFACE -Wall -Wextra -Werror -Wno-psabi)

add_library(heartbus_dealii INTERFACE)
target_include_directories(heartbus_dealii SYSTEM INTERFACE ${DEAL_II_INCLUDE_DIRS})
# deal.II's headers call into the libraries behind it (Trilinos, TBB, p4est); let the linker find them through deal.II.
target_link_options(heartbus_dealii INTERFACE -Wl,--copy-dt-needed-entries)
if(CMAKE_BUILD_TYPE STREQUAL "Debug")
  target_link_libraries(heartbus_dealii INTERFACE ${DEAL_II_TARGET_DEBUG})
  target_compile_definitions(heartbus_dealii INTERFACE DEBUG BOOST_NO_AUTO_PTR)
else()
  target_link_libraries(heartbus_dealii INTERFACE ${DEAL_II_TARGET_RELEASE})
  target_compile_definitions(heartbus_dealii INTERFACE BOOST_NO_AUTO_PTR)
endif()

add_library(heartbus_pch OBJECT ${CMAKE_SOURCE_DIR}/cmake/pch.cpp)
target_link_libraries(heartbus_pch PUBLIC heartbus_options heartbus_dealii MPI::MPI_CXX)
target_precompile_headers(heartbus_pch PRIVATE ${CMAKE_SOURCE_DIR}/cmake/pch.h)

# fem::Lanes is aligned to 16 bytes on the baseline machine, so that is what memory holds; but in the versions for wider
# machines (HEARTBUS_SIMD) the compiler loads it with instructions that fault below 32 or 64. The assembler can replace them
# by their unaligned forms, which are as fast.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|amd64|AMD64")
  set(heartbus_unaligned "-Wa,-muse-unaligned-vector-move")
endif()

# heartbus_library(NAME [DEALII] SOURCES folders-or-files LIBS ...): library heartbus_NAME of all sources below the
# folders, except main*.cpp and what another library of the same folder owns.
function(heartbus_library name)
  cmake_parse_arguments(A "DEALII" "" "SOURCES;LIBS" ${ARGN})
  set(files "")
  foreach(source ${A_SOURCES})
    if(source MATCHES "\\.cpp$")
      list(APPEND files ${CMAKE_SOURCE_DIR}/${source})
    else()
      file(GLOB_RECURSE found CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/${source}/*.cpp)
      list(APPEND files ${found})
    endif()
  endforeach()
  list(FILTER files EXCLUDE REGEX "/main[^/]*\\.cpp$")
  if(NOT name STREQUAL "schema")
    list(FILTER files EXCLUDE REGEX "_solver/parameters\\.cpp$")
  endif()
  if(NOT name STREQUAL "models")
    list(FILTER files EXCLUDE REGEX "/(ionic|constitutive|active)/|/fluid_solver/(valves|navier_stokes_kernel)\\.cpp$")
  endif()
  # Compute kernels hold no deal.II type: they get -O3, and no precompiled header.
  set(kernels ${files})
  list(FILTER kernels INCLUDE REGEX "(_kernel\\.cpp|/ionic/[^/]*\\.cpp)$")
  set_source_files_properties(${kernels} PROPERTIES SKIP_PRECOMPILE_HEADERS ON
    COMPILE_OPTIONS "-O3;-fno-math-errno;-fno-trapping-math;${heartbus_unaligned}")
  if(files)
    add_library(heartbus_${name} STATIC ${files})
    target_link_libraries(heartbus_${name} PUBLIC heartbus_options ${A_LIBS})
    if(A_DEALII)
      target_link_libraries(heartbus_${name} PUBLIC heartbus_dealii MPI::MPI_CXX)
      target_precompile_headers(heartbus_${name} REUSE_FROM heartbus_pch)
    endif()
  else()
    add_library(heartbus_${name} INTERFACE)
    target_link_libraries(heartbus_${name} INTERFACE heartbus_options ${A_LIBS})
  endif()
endfunction()

# heartbus_program(NAME LIBRARIES...): the program of folder NAME, from its main.cpp.
function(heartbus_program name library)
  if(EXISTS ${CMAKE_SOURCE_DIR}/${name}/main.cpp)
    add_executable(${name} ${name}/main.cpp)
    target_link_libraries(${name} PRIVATE ${library} ${ARGN})
    if(NOT name MATCHES "^(coupler|replay)$") # these know no deal.II
      target_precompile_headers(${name} REUSE_FROM heartbus_pch)
    endif()
  endif()
endfunction()
