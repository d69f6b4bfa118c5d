#include "compiler/analysis/standing.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <variant>
#include <vector>

#include "compiler/schema/parametrised_words.h"

namespace cdb::analysis {
namespace {

using Eigen::Vector3d;
using schema::ArgumentOf;

/// In least sides: how far an object may fall, or reach into its support.
constexpr double kFall = 0.05, kReach = 1e-6;

struct Block {
  Vector3d centre, half;  ///< m
  bool is_round = false;
};

/// Nullopt unless the objects are equal, upright and flat below and above.
std::optional<Block> BlockOf(const plan::Group& group) {
  const std::string_view type = group.settings.WordOr("type");
  const schema::Number* size = schema::AsNumber(group.settings.Get("size"));
  const auto* aspect = std::get_if<schema::Ratio>(&group.settings.Get("aspect"));
  if ((type != "cuboid" && type != "cylinder") || size == nullptr || aspect == nullptr ||
      !schema::IsZero(group.settings.Get("orientation")))
    return std::nullopt;
  return Block{Vector3d::Zero(), size->AsReal() / 2 * aspect->parts, type == "cylinder"};
}

std::optional<double> RealOf(const schema::Call& layout, std::string_view name) {
  const schema::Number* number = schema::AsNumber(ArgumentOf(layout, name));
  return number != nullptr ? std::optional(number->AsReal()) : std::nullopt;
}

/// As library/layouts places them.
void AddStack(const schema::Call& layout, std::size_t count, double floor, Block block,
              std::vector<Block>& blocks) {
  const std::size_t height =
      static_cast<std::size_t>(RealOf(layout, "height").value_or(static_cast<double>(count)));
  const std::size_t columns = (count + height - 1) / height;
  std::size_t edge = 0;
  while (edge * edge < columns) ++edge;
  const double spacing =
      RealOf(layout, "spacing").value_or(3 * std::max(block.half.x(), block.half.z()));
  const double tall = 2 * block.half.y();
  const double step = tall + RealOf(layout, "gap").value_or(1e-3 * tall);
  const auto along = [&](std::size_t cell) {
    return (static_cast<double>(cell) - static_cast<double>(edge - 1) / 2) * spacing;
  };
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t column = i / height;
    block.centre = {along(column % edge),
                    floor + static_cast<double>(i % height + 1) * step - block.half.y(),
                    along(column / edge)};
    blocks.push_back(block);
  }
}

void AddPoints(const schema::Call& layout, Block block, std::vector<Block>& blocks) {
  if (schema::ListsPoints(layout)) {
    for (const schema::Value& point : layout.arguments)
      if (const auto* at = std::get_if<Vector3d>(&point)) {
        block.centre = *at;
        blocks.push_back(block);
      }
    return;
  }
  for (int axis = 0; axis < 3; ++axis)
    block.centre[axis] = RealOf(layout, std::string_view("xyz").substr(axis, 1)).value_or(0);
  blocks.push_back(block);
}

/// The objects of the groups whose positions the plan tells.
std::vector<Block> BlocksOf(const plan::Scene& scene) {
  std::vector<Block> blocks;
  for (const plan::Group& group : scene.groups) {
    const schema::Call* layout = schema::AsCall(group.settings.Get("location"));
    const auto block = BlockOf(group);
    if (layout == nullptr || !block) continue;
    if (layout->name == "stack")
      AddStack(*layout, group.settings.Count("quantity"), -scene.world.Real("world.side") / 2,
               *block, blocks);
    if (layout->name == "at") AddPoints(*layout, *block, blocks);
  }
  return blocks;
}

bool Bears(const Block& lower, const Block& upper) {
  const Vector3d way = upper.centre - lower.centre;
  const double gap = way.y() - lower.half.y() - upper.half.y();
  const double least = 2 * upper.half.minCoeff();
  const bool is_above =
      lower.is_round ? std::hypot(way.x(), way.z()) < lower.half.x()
                     : std::abs(way.x()) < lower.half.x() && std::abs(way.z()) < lower.half.z();
  return is_above && gap > -kReach * least && gap <= kFall * least;
}

}  // namespace

bool StandsOnOthers(const plan::Scene& scene, const plan::Group& group) {
  const schema::Call* layout = schema::AsCall(group.settings.Get("location"));
  const auto block = BlockOf(group);
  if (layout == nullptr || layout->name != "at" || !block) return false;
  std::vector<Block> own;
  AddPoints(*layout, *block, own);
  const std::vector<Block> all = BlocksOf(scene);
  const double side = scene.world.Real("world.side");
  const Block floor = {{0, -side, 0}, {side, side / 2, side}};
  return std::ranges::all_of(own, [&](const Block& upper) {
    return Bears(floor, upper) ||
           std::ranges::any_of(all, [&](const Block& lower) { return Bears(lower, upper); });
  });
}

}  // namespace cdb::analysis
