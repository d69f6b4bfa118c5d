#include "library/objects/ground_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "compiler/schema/parametrised_words.h"
#include "library/objects/surface.h"
#include "library/scene_error.h"
#include "library/terrain/voxel_grid.h"

namespace cdb::objects {
namespace {

using Eigen::Vector3d;

terrain::HeightOptions HeightOptionsOf(const schema::Call& call) {
  terrain::HeightOptions options;
  // Other values are the words `unit`, `file`, `refuse` and `lowest`.
  const schema::Number* cell = schema::AsNumber(ArgumentOf(call, "cell"));
  if (cell != nullptr) options.scale = Vector3d(cell->AsReal(), 1, cell->AsReal());
  if (const Vector3d* scale = schema::AsVector(ArgumentOf(call, "scale"))) {
    if (cell != nullptr)
      throw library::SceneError("heights has a cell as well as a scale",
                                "remove the cell; `scale` has the sides of a cell, too");
    if (!(scale->minCoeff() > 0))
      throw library::SceneError("the scale of heights must be more than 0 along each axis",
                                "for example `scale: (30, 1, 30)`");
    options.scale = *scale;
  }
  const schema::Value& no_data = ArgumentOf(call, "no_data");
  if (const schema::Number* height = schema::AsNumber(no_data)) {
    options.no_data = height->AsReal();
  } else if (std::get<schema::Word>(no_data).text == "lowest") {
    options.no_data = terrain::HeightOptions::Lowest();
  }
  return options;
}

ConvexDecomposition FormOfHeights(const std::string& name, const schema::Call& call,
                                  const std::string& bytes) {
  const auto& file = std::get<schema::Text>(ArgumentOf(call, "file")).text;
  return MakeSurface(name, std::make_shared<const terrain::HeightGrid>(
                               terrain::ParseHeights(bytes, file, HeightOptionsOf(call))));
}

ConvexDecomposition FormOfVoxels(const std::string& name, const schema::Call& call,
                                 const std::string& bytes) {
  const auto& file = std::get<schema::Text>(ArgumentOf(call, "file")).text;
  const auto word = [&](const char* argument) -> std::string_view {
    return std::get<schema::Word>(ArgumentOf(call, argument)).text;
  };
  const auto count = [&](const char* argument) -> std::optional<std::uint64_t> {
    const schema::Number* number = schema::AsNumber(ArgumentOf(call, argument));
    if (number == nullptr) return std::nullopt;
    return static_cast<std::uint64_t>(std::min(number->AsReal(), 1e18));
  };
  terrain::VoxelOptions options;
  if (word("up") == "unstated")
    throw library::SceneError(fmt::format("{}: it does not say which of its axes is up", file),
                              "add `up: z`, or `up: y`");
  options.is_z_up = word("up") == "z";
  if (const schema::Number* cell = schema::AsNumber(ArgumentOf(call, "cell")))
    options.cell = cell->AsReal();
  options.counts = {count("columns"), count("rows"), count("layers")};
  options.threshold = count("threshold").value_or(1);
  auto grid =
      std::make_shared<const terrain::VoxelGrid>(terrain::ParseVoxels(bytes, file, options));
  ConvexDecomposition form =
      MakeSurface(name, terrain::SurfaceOf(*grid, file, kMaxSurfaceTriangles));
  form.voxels = std::move(grid);
  if (word("origin") == "file") form.origin = form.file_origin;
  return form;
}

}  // namespace

bool IsGroundFile(const schema::Call& type) {
  return type.name == schema::kHeightsCall || type.name == schema::kVoxelsCall;
}

ConvexDecomposition GroundOfFile(const std::string& name, const schema::Call& type,
                                 const std::string& bytes) {
  return type.name == schema::kHeightsCall ? FormOfHeights(name, type, bytes)
                                           : FormOfVoxels(name, type, bytes);
}

}  // namespace cdb::objects
