# Helpers of the build: one library per folder, one tiny main per program.

add_library(heartbus_options INTERFACE)
target_include_directories(heartbus_options INTERFACE ${PROJECT_SOURCE_DIR})
# psabi: the notes about vector types passed between functions do not concern us, they stay inside one file.
if(PROJECT_IS_TOP_LEVEL)
  target_compile_options(heartbus_options INTERFACE -Wall -Wextra -Werror -Wno-psabi)
endif()

# fem::VectorizedDouble is aligned to 16 bytes on the baseline machine, so that is what memory holds; but in the versions for wider
# machines (HEARTBUS_SIMD) the compiler loads it with instructions that fault below 32 or 64. The assembler can replace them
# by their unaligned forms, which are as fast.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|amd64|AMD64")
  set(heartbus_unaligned "-Wa,-muse-unaligned-vector-move")
endif()

# heartbus_library(NAME [DEALII] SOURCES folders LIBS ...): library heartbus_NAME of all sources in the folders (not of
# those below), except main*.cpp.
function(heartbus_library name)
  cmake_parse_arguments(A "DEALII" "" "SOURCES;LIBS" ${ARGN})
  set(files "")
  foreach(source ${A_SOURCES})
    file(GLOB found CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${source}/*.cpp)
    list(APPEND files ${found})
  endforeach()
  list(FILTER files EXCLUDE REGEX "/main[^/]*\\.cpp$")
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
  if(EXISTS ${PROJECT_SOURCE_DIR}/${name}/main.cpp)
    add_executable(${name} ${name}/main.cpp)
    target_link_libraries(${name} PRIVATE ${library} ${ARGN})
    if(NOT name MATCHES "^(cavity_solver|coupler|replay|stand_in)$") # these know no deal.II
      target_precompile_headers(${name} REUSE_FROM heartbus_pch)
    endif()
  endif()
endfunction()
