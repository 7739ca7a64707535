# Installs the build into its own tree and builds and runs an outside project, by find_package and by pkg-config. Given:
# BUILD_DIR, WORK_DIR, COMPILER, and PKG_CONFIG where there is one.
file(REMOVE_RECURSE ${WORK_DIR})
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code)
  if(NOT code EQUAL 0)
    list(JOIN ARGN " " words)
    message(FATAL_ERROR "${words}: ${code}")
  endif()
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/prefix)
run(${WORK_DIR}/prefix/bin/viscobar --version)
foreach(file man/man1/viscobar.1 bash-completion/completions/viscobar)
  if(NOT EXISTS ${WORK_DIR}/prefix/share/${file})
    message(FATAL_ERROR "share/${file} is not installed")
  endif()
endforeach()

# Moved: nothing may point to where it was installed first, or into the build.
file(RENAME ${WORK_DIR}/prefix ${WORK_DIR}/moved)
run(${CMAKE_COMMAND} -G Ninja -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK_DIR}/outside -DCMAKE_CXX_COMPILER=${COMPILER}
    -DCMAKE_PREFIX_PATH=${WORK_DIR}/moved "-DCMAKE_CXX_FLAGS=${FLAGS}")
run(${CMAKE_COMMAND} --build ${WORK_DIR}/outside)
run(${CMAKE_COMMAND} -E chdir ${WORK_DIR} ${WORK_DIR}/outside/outside)

file(GLOB_RECURSE pc ${WORK_DIR}/moved/viscobar.pc)
get_filename_component(pc_dir ${pc} DIRECTORY)
set(ENV{PKG_CONFIG_PATH} ${pc_dir})
execute_process(COMMAND ${PKG_CONFIG} --cflags --libs viscobar OUTPUT_VARIABLE options RESULT_VARIABLE code)
if(NOT code EQUAL 0)
  message(FATAL_ERROR "pkg-config does not know viscobar")
endif()
separate_arguments(options UNIX_COMMAND "${options} ${FLAGS}")
get_filename_component(lib_dir ${pc_dir} DIRECTORY)
run(${COMPILER} ${CMAKE_CURRENT_LIST_DIR}/outside.cpp -o ${WORK_DIR}/by-pkg-config ${options} -Wl,-rpath,${lib_dir})
run(${CMAKE_COMMAND} -E chdir ${WORK_DIR} ${WORK_DIR}/by-pkg-config)
