# cmake --install: the program, the library, its headers, and what find_package(viscobar) and pkg-config need.
include(CMakePackageConfigHelpers)

set_target_properties(viscobar PROPERTIES VERSION ${PROJECT_VERSION}
                                          SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/viscobar)
install(TARGETS viscobar EXPORT viscobarTargets)
install(DIRECTORY include/viscobar TYPE INCLUDE FILES_MATCHING PATTERN "*.hpp")
install(EXPORT viscobarTargets NAMESPACE viscobar:: DESTINATION ${package_dir})
if(TARGET viscobar_cli)
  file(RELATIVE_PATH libraries_from_program ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
  set_target_properties(viscobar_cli PROPERTIES INSTALL_RPATH "$ORIGIN/${libraries_from_program}")
  install(TARGETS viscobar_cli)
endif()

# A static library leaves the linking of what it uses to whom it is linked into.
get_target_property(viscobar_type viscobar TYPE)
get_target_property(linked viscobar LINK_LIBRARIES)
list(FILTER linked INCLUDE REGEX "^SUNDIALS::")
list(TRANSFORM linked REPLACE "^SUNDIALS::" "" OUTPUT_VARIABLE sundials_components)
list(JOIN sundials_components " " sundials_component_words)
configure_package_config_file(cmake/viscobarConfig.cmake.in viscobarConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(viscobarConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/viscobarConfig.cmake ${PROJECT_BINARY_DIR}/viscobarConfigVersion.cmake
        DESTINATION ${package_dir})

set(pkgconfig_requires "")
set(pkgconfig_libraries "-lviscobar")
if(viscobar_type STREQUAL "STATIC_LIBRARY")
  set(pkgconfig_requires "fmt, muparser")
  foreach(component ${sundials_components})
    string(APPEND pkgconfig_libraries " -lsundials_${component}")
  endforeach()
  list(GET HDF5_C_LIBRARIES 0 hdf5_library)
  string(APPEND pkgconfig_libraries " ${hdf5_library}")
endif()
file(RELATIVE_PATH prefix_from_pkgconfig ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
configure_file(cmake/viscobar.pc.in viscobar.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/viscobar.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
