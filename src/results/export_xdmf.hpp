#pragma once

#include <filesystem>

#include "results/field/field_reader.hpp"

namespace viscobar {

/// Writes a field as `field.h5` and `field.xdmf` in `target`, with a dataset for each time (u/0, u/1, ...): for readers
/// that know no part of a dataset, such as meshio. @throws IoError
void export_xdmf(const FieldReader& field, const std::filesystem::path& target);

}  // namespace viscobar
