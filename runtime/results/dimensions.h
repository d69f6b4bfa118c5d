// The dimensions of a results file, with their coordinates.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/results/hdf5/object.h"

namespace cdb::results {

/// A dimension with its coordinate, a dataset of the same name.
struct Dimension {
  std::string name;  ///< including its group: `run/quantity`
  std::uint64_t size = 0;
  hdf5::Type type = hdf5::Type::kInt32;
  std::vector<double> numbers;     ///< the coordinate: `size` numbers,
  std::vector<std::string> texts;  ///< or texts; neither: a dimension without a coordinate
  std::map<std::string, std::string> attributes;
  std::string units_by_label;  ///< separated by spaces, if the labels differ in unit
};

/// The numbers from 0 to `n` - 1.
std::vector<double> Indices(std::uint64_t n);
/// A dimension of indices. `doc`: its `long_name`.
Dimension Counted(std::string name, std::uint64_t size, std::string doc);
/// A dimension of words. Readers that cannot read text datasets (Octave) find them in the attribute
/// `labels`, which is left out if one word contains every separator.
Dimension Labelled(std::string name, std::vector<std::string> texts, std::string doc);
/// The unit of a number without one, by the netCDF Climate and Forecast conventions.
inline constexpr const char* kNoUnit = "1";
/// The values of an axis. `is_integer`: the result of Axis::IsInteger, which checks all values.
Dimension AxisDimension(const plan::Axis& axis, bool is_integer);

}  // namespace cdb::results
