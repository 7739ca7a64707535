# VISCOBAR_STATIC_HDF5: whether the program can have the HDF5 that it uses inside. The shared library of a distribution needs
# some thirty libraries of network protocols, which take longer to load than a small bar to run. Nothing else is linked so:
# an archive need not be fit for a shared library.
include(CheckCSourceCompiles)
list(GET HDF5_C_LIBRARIES 0 hdf5_shared)
get_filename_component(hdf5_folder "${hdf5_shared}" DIRECTORY)
find_library(HDF5_ARCHIVE libhdf5.a HINTS ${hdf5_folder} NO_DEFAULT_PATH)
add_library(viscobar_static_hdf5 INTERFACE IMPORTED)
target_include_directories(viscobar_static_hdf5 INTERFACE ${HDF5_INCLUDE_DIRS})
target_link_libraries(viscobar_static_hdf5 INTERFACE ${HDF5_ARCHIVE} sz aec ZLIB::ZLIB ${CMAKE_DL_LIBS} m)
# Its functions keep their names, for those who look at a call's stack (tests/checkpoint/faults.c).
target_link_options(viscobar_static_hdf5 INTERFACE "LINKER:--export-dynamic-symbol=H5*")
if(HDF5_ARCHIVE)
  set(CMAKE_REQUIRED_LIBRARIES viscobar_static_hdf5)
  check_c_source_compiles("#include <hdf5.h>\nint main(void) { return H5open(); }" VISCOBAR_STATIC_HDF5)
  unset(CMAKE_REQUIRED_LIBRARIES)
endif()
