#pragma once

#include <filesystem>
#include <string>

#include "results/field/hdf5_handle.hpp"

namespace viscobar {

/// The text of an attribute of a file's object, "none" where there is no such attribute.
inline std::string attribute(const std::filesystem::path& file, const char* object, const char* name) {
  const Hdf5File h5(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT));
  if (H5Aexists_by_name(h5.get(), object, name, H5P_DEFAULT) <= 0) return "none";
  const Hdf5Attribute found(H5Aopen_by_name(h5.get(), object, name, H5P_DEFAULT, H5P_DEFAULT));
  const Hdf5Type type(H5Aget_type(found.get()));
  char* value = nullptr;
  H5Aread(found.get(), type.get(), &value);
  std::string text = value;
  H5free_memory(value);
  return text;
}

}  // namespace viscobar
