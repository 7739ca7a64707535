# cmake --install: the program with its man page and completions (component "program"), and the library, its headers and
# what find_package(viscobar) and pkg-config need (component "development").
include(CMakePackageConfigHelpers)

set_target_properties(viscobar PROPERTIES VERSION ${PROJECT_VERSION}
                                          SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
# One search path for the build and the installation: CMake pads another by empty entries, which the loader takes for the
# directory that it is started in.
set_target_properties(viscobar ${programs} PROPERTIES BUILD_WITH_INSTALL_RPATH ON INSTALL_RPATH_USE_LINK_PATH ON)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/viscobar)
install(TARGETS viscobar EXPORT viscobarTargets
        ARCHIVE COMPONENT development LIBRARY COMPONENT program NAMELINK_COMPONENT development)
install(DIRECTORY include/viscobar TYPE INCLUDE COMPONENT development FILES_MATCHING PATTERN "*.hpp")
install(EXPORT viscobarTargets NAMESPACE viscobar:: DESTINATION ${package_dir} COMPONENT development)
if(TARGET viscobar_cli)
  if(BUILD_SHARED_LIBS)  # installed, and as it is built, beside the program
    file(RELATIVE_PATH libraries_from_program ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
    set_target_properties(${programs} PROPERTIES INSTALL_RPATH "$ORIGIN/${libraries_from_program};$ORIGIN")
  endif()
  install(TARGETS ${programs} COMPONENT program)
  set(shell_dir ${PROJECT_SOURCE_DIR}/cmake/shell)
  add_custom_command(TARGET viscobar_cli POST_BUILD VERBATIM
                     COMMAND sh ${shell_dir}/man.sh $<TARGET_FILE:viscobar_cli> > ${PROJECT_BINARY_DIR}/viscobar.1)
  install(FILES ${PROJECT_BINARY_DIR}/viscobar.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program)
  install(FILES ${shell_dir}/viscobar.bash RENAME viscobar
          DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT program)
  install(FILES ${shell_dir}/viscobar.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d COMPONENT program)
  install(DIRECTORY examples/scenes examples/data DESTINATION ${CMAKE_INSTALL_DOCDIR}/examples COMPONENT program)
endif()

# A static library leaves the linking of what it uses to whom it is linked into.
get_target_property(viscobar_type viscobar TYPE)
list(JOIN sundials_components " " sundials_component_words)
configure_package_config_file(cmake/viscobarConfig.cmake.in viscobarConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(viscobarConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/viscobarConfig.cmake ${PROJECT_BINARY_DIR}/viscobarConfigVersion.cmake
        DESTINATION ${package_dir} COMPONENT development)

set(pkgconfig_requires "")
set(pkgconfig_libraries "-lviscobar")
if(viscobar_type STREQUAL "STATIC_LIBRARY")
  set(pkgconfig_requires "fmt, zlib, liblzma")
  foreach(component ${sundials_components})
    string(APPEND pkgconfig_libraries " -lsundials_${component}")
  endforeach()
  if(TARGET SUNDIALS::core) # version 7, which names MPI's communicators where it was built with MPI
    string(APPEND pkgconfig_libraries " -lsundials_core")
    get_target_property(core_needs SUNDIALS::core_shared INTERFACE_LINK_LIBRARIES)
    if(core_needs MATCHES "MPI::")
      list(JOIN MPI_C_LIBRARIES " " mpi_libraries)
      string(APPEND pkgconfig_libraries " ${mpi_libraries}")
    endif()
  endif()
  list(GET HDF5_C_LIBRARIES 0 hdf5_library)
  string(APPEND pkgconfig_libraries " ${hdf5_library}")
endif()
file(RELATIVE_PATH prefix_from_pkgconfig ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
configure_file(cmake/viscobar.pc.in viscobar.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/viscobar.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig
        COMPONENT development)
