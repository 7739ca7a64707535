#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <vector>

#include "results/field/hdf5_handle.hpp"

namespace viscobar {

/// field.h5 of a run, finished or not, row by row. @throws IoError
class FieldReader {
 public:
  enum class Quantity { displacement, velocity, stress };
  static constexpr std::array quantities = {Quantity::displacement, Quantity::velocity, Quantity::stress};
  static const char* name(Quantity quantity);  ///< u, v, stress

  explicit FieldReader(const std::filesystem::path& file);

  const std::vector<double>& x() const { return x_; }
  const std::vector<double>& times() const { return times_; }  ///< of the rows that are whole
  std::size_t rows() const { return times_.size(); }
  std::size_t nodes() const { return x_.size(); }

  /// True if the file has it: one of an earlier version has no stress.
  bool has(Quantity quantity) const { return dataset(quantity).get() >= 0; }
  /// Values of a row: one a node, of the stress one an element.
  std::size_t width(Quantity quantity) const { return nodes() - (quantity == Quantity::stress ? 1 : 0); }
  /// Values for the output times first, first + 1, ..., as many as `values` has room for.
  void read(Quantity quantity, std::size_t first, std::span<double> values) const;

 private:
  const Hdf5Dataset& dataset(Quantity quantity) const { return datasets_[static_cast<std::size_t>(quantity)]; }

  std::filesystem::path path_;
  Hdf5File file_;
  std::vector<double> x_, times_;
  std::array<Hdf5Dataset, quantities.size()> datasets_;
};

}  // namespace viscobar
