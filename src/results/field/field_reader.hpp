#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "results/field/hdf5_handle.hpp"

namespace viscobar {

/// field.h5 of a run, finished or not, row by row. @throws IoError
class FieldReader {
 public:
  explicit FieldReader(const std::filesystem::path& file);

  const std::vector<double>& x() const { return x_; }
  const std::vector<double>& times() const { return times_; }  ///< of the rows that are whole
  std::size_t rows() const { return times_.size(); }
  std::size_t nodes() const { return x_.size(); }

  enum class Quantity { displacement, velocity, stress };
  /// Whether the file has it: one of an earlier version has no stress.
  bool has(Quantity quantity) const { return quantity != Quantity::stress || stress_; }
  /// Values of a row: one a node, of the stress one an element.
  std::size_t width(Quantity quantity) const { return nodes() - (quantity == Quantity::stress ? 1 : 0); }
  /// Values for the output times first, first + 1, ..., as many as `values` has room for.
  void read(Quantity quantity, std::size_t first, std::span<double> values) const;

 private:
  std::filesystem::path path_;
  Hdf5File file_;
  Hdf5Dataset u_, v_;
  std::optional<Hdf5Dataset> stress_;
  std::vector<double> x_, times_;
};

}  // namespace viscobar
