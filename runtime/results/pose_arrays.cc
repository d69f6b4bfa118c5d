#include "runtime/results/pose_arrays.h"

#include <fmt/format.h>

#include "runtime/results/hdf5/file.h"
#include "runtime/results/store.h"

namespace cdb::results {
namespace {

constexpr std::uint64_t kMostObjects = 100'000'000;

/// The rows of a dataset of `width` columns; empty if there is none.
std::vector<double> ReadRows(const hdf5::File& file, const std::string& path, const char* name,
                             std::uint64_t width, std::uint64_t rows) {
  if (!file.Has(name)) return {};
  const hdf5::Dataset dataset = file.OpenDataset(name);
  const hdf5::Shape& shape = dataset.shape();
  const bool fits = dataset.type() != hdf5::Type::kText && shape.size() == 2 && shape[1] == width &&
                    shape[0] > 0 && shape[0] <= kMostObjects && (rows == 0 || shape[0] == rows);
  if (!fits)
    throw files::StoreError(
        fmt::format("{}: its `{}` should be an array of numbers with {} and {} columns", path, name,
                    rows == 0 ? "a row for each object" : fmt::format("{} rows", rows), width));
  return dataset.Read();
}

}  // namespace

std::optional<PoseArrays> ReadPoseArrays(const std::filesystem::path& path) {
  const std::string name = path.string();
  try {
    const hdf5::File file = hdf5::File::Open(path);
    if (!file.Has("position")) return std::nullopt;
    PoseArrays arrays;
    arrays.position = ReadRows(file, name, "position", 3, 0);
    const std::uint64_t rows = arrays.position.size() / 3;
    arrays.orientation = ReadRows(file, name, "orientation", 4, rows);
    arrays.linear_velocity = ReadRows(file, name, "linear_velocity", 3, rows);
    arrays.angular_velocity = ReadRows(file, name, "angular_velocity", 3, rows);
    return arrays;
  } catch (const hdf5::Error& error) {
    throw files::StoreError(
        fmt::format("{}: it is not HDF5 that can be read: {}", name, error.what()));
  }
}

}  // namespace cdb::results
