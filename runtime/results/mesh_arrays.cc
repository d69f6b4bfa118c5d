#include "runtime/results/mesh_arrays.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "library/scene_error.h"
#include "runtime/results/files/errors.h"
#include "runtime/results/hdf5/file.h"

namespace cdb::results {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRemedy =
    "write f[\"vertices\"] of frames x vertices x 3 and f[\"faces\"] of triangles x 3";

[[noreturn]] void RefuseArray(const fs::path& path, const char* name, const std::string& why) {
  throw files::StoreError(fmt::format("{}: its `{}` {}; {}", path.string(), name, why, kRemedy));
}

/// An array of `dimensions`, the last of which is 3.
hdf5::Numbers ReadTriples(const hdf5::File& file, const fs::path& path, const char* name,
                          std::size_t dimensions) {
  if (!file.Has(name))
    throw files::StoreError(
        fmt::format("{}: it has no dataset `{}`; {}", path.string(), name, kRemedy));
  hdf5::Numbers numbers;
  try {
    numbers = file.ReadNumbers(name);
  } catch (const hdf5::Error& error) {
    RefuseArray(path, name, fmt::format("cannot be used: {}", error.what()));
  }
  if (numbers.shape.size() != dimensions || numbers.shape.back() != 3)
    RefuseArray(path, name, fmt::format("has the shape {}", fmt::join(numbers.shape, " x ")));
  if (numbers.is_from_matlab)
    RefuseArray(path, name, "is from MATLAB, which stores arrays transposed");
  return numbers;
}

}  // namespace

deforming::MeshSequence ReadMeshArrays(const fs::path& path) {
  deforming::MeshSequence sequence;
  try {
    const hdf5::File file = hdf5::File::Open(path);
    const hdf5::Numbers faces = ReadTriples(file, path, "faces", 2);
    for (std::size_t i = 0; i < faces.values.size(); i += 3) {
      deforming::Triangle triangle = {};
      for (std::size_t k = 0; k < 3; ++k) {
        const double corner = faces.values[i + k];
        if (!(corner >= 0 && corner < static_cast<double>(meshes::kMaxVertices)) ||
            corner != std::floor(corner))
          RefuseArray(path, "faces",
                      fmt::format("has {} in row {}, which is no index of a vertex, counted from 0",
                                  corner, i / 3));
        triangle[k] = static_cast<std::uint32_t>(corner);
      }
      sequence.triangles.push_back(triangle);
    }
    const hdf5::Numbers vertices = ReadTriples(file, path, "vertices", 3);
    const std::size_t count = vertices.shape[1];
    const double* at = vertices.values.data();
    for (std::size_t frame = 0; frame < vertices.shape[0]; ++frame) {
      auto& positions = sequence.frames.emplace_back();
      positions.reserve(count);
      for (std::size_t i = 0; i < count; ++i, at += 3) positions.emplace_back(at[0], at[1], at[2]);
    }
  } catch (const hdf5::Error& error) {
    throw files::StoreError(
        fmt::format("{}: it is not HDF5 that can be read: {}", path.string(), error.what()));
  }
  try {
    deforming::CheckSequence(sequence, path.string());
  } catch (const library::SceneError& error) {
    throw files::StoreError(error.what());
  }
  return sequence;
}

}  // namespace cdb::results
