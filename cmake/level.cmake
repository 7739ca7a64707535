# VISCOBAR_LEVEL: the level of x86-64 that all is compiled for. A program that a processor below it starts says so in words
# (src/cli/level.cpp). Empty: the highest that this processor has; native: this processor itself.
set(VISCOBAR_LEVEL "" CACHE STRING "x86-64, x86-64-v2 (SSE4.2), x86-64-v3 (AVX2), x86-64-v4 (AVX-512), native; empty: this machine's")
set(VISCOBAR_LEVELS_BESIDE "" CACHE STRING "Levels that the program and the Python package are built for as well: the highest that a processor has is run")

set(level "${VISCOBAR_LEVEL}")
set(levels x86-64 x86-64-v2 x86-64-v3 x86-64-v4)
if(NOT CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64|amd64)$")
  if(NOT level STREQUAL "native") # other processors have no such levels
    set(level "")
  endif()
elseif("${level}" STREQUAL "")
  execute_process(COMMAND ${CMAKE_CXX_COMPILER} -march=native -dM -E -x c++ /dev/null OUTPUT_VARIABLE macros ERROR_QUIET)
  set(level x86-64)
  foreach(candidate "x86-64-v2 SSE4_2" "x86-64-v3 AVX2 FMA BMI2 LZCNT" "x86-64-v4 AVX512F AVX512BW AVX512CD AVX512DQ AVX512VL")
    separate_arguments(candidate)
    list(POP_FRONT candidate name)
    foreach(feature IN LISTS candidate)
      if(NOT macros MATCHES "__${feature}__ 1")
        set(name "")
      endif()
    endforeach()
    if(name)
      set(level ${name})
    endif()
  endforeach()
  message(STATUS "Compiled for ${level}, this processor's level")
elseif(NOT level STREQUAL "native" AND NOT level IN_LIST levels)
  message(FATAL_ERROR "VISCOBAR_LEVEL is \"${level}\", none of native, ${levels}")
endif()
set(level_name "${level}")
if(level_name STREQUAL "")
  set(level_name ${CMAKE_SYSTEM_PROCESSOR})
endif()
if(NOT level STREQUAL "")
  target_compile_options(viscobar_options INTERFACE -march=${level})
endif()

# Before main, compiled for any processor of the kind.
file(RELATIVE_PATH levels_from_program ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR}/viscobar)
set_source_files_properties(src/cli/level.cpp PROPERTIES
                            COMPILE_DEFINITIONS "VISCOBAR_LEVEL=\"${level_name}\";VISCOBAR_LEVELS=\"${levels_from_program}\"")
if(level IN_LIST levels)
  set_source_files_properties(src/cli/level.cpp PROPERTIES COMPILE_OPTIONS -march=x86-64)
endif()

# The other levels, each a build of its own within this one.
function(build_levels_beside)
  include(ExternalProject)
  foreach(beside IN LISTS VISCOBAR_LEVELS_BESIDE)
    set(folder ${PROJECT_BINARY_DIR}/levels/${beside})
    set(targets viscobar_cli)
    if(TARGET viscobar_python)
      list(APPEND targets viscobar_python)
    endif()
    ExternalProject_Add(viscobar_${beside} SOURCE_DIR ${PROJECT_SOURCE_DIR} BINARY_DIR ${folder} BUILD_ALWAYS ON USES_TERMINAL_BUILD ON
      CMAKE_ARGS -DVISCOBAR_LEVEL=${beside} -DCMAKE_BUILD_TYPE=${CMAKE_BUILD_TYPE} -DVISCOBAR_TESTS=OFF -DVISCOBAR_LEVELS_BESIDE_OF=${level} -DVISCOBAR_PYTHON=${VISCOBAR_PYTHON}
                 -DVISCOBAR_PYTHON_DIR=${VISCOBAR_PYTHON_DIR} -DCMAKE_INSTALL_PREFIX=${CMAKE_INSTALL_PREFIX} -DSUNDIALS_ROOT=${SUNDIALS_ROOT}
      BUILD_COMMAND ${CMAKE_COMMAND} --build ${folder} --target ${targets}
      INSTALL_COMMAND "")
    foreach(program IN LISTS programs)
      install(PROGRAMS ${folder}/$<TARGET_FILE_NAME:${program}> DESTINATION ${CMAKE_INSTALL_LIBDIR}/viscobar/${beside} COMPONENT program)
    endforeach()
  endforeach()
endfunction()
