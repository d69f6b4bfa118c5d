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
/// More are not examined.
constexpr std::size_t kMostBlocks = 1000;

struct Block {
  Vector3d centre, half;  ///< m
  double mass = 0;        ///< kg
  bool is_round = false;
};

/// Nullopt unless the objects are equal, upright and flat below and above.
std::optional<Block> BlockOf(const plan::Group& group) {
  const std::string_view type = group.settings.WordOr("type");
  const schema::Number* size = schema::AsNumber(group.settings.Get("size"));
  const auto* aspect = std::get_if<schema::Ratio>(&group.settings.Get("aspect"));
  const schema::Number* mass = schema::AsNumber(group.settings.Get("mass"));
  if ((type != "cuboid" && type != "cylinder") || size == nullptr || aspect == nullptr ||
      mass == nullptr || !schema::IsZero(group.settings.Get("orientation")))
    return std::nullopt;
  return Block{Vector3d::Zero(), size->AsReal() / 2 * aspect->parts, mass->AsReal(),
               type == "cylinder"};
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
    if (layout->name == "stack" && !IsInBox(group.settings))
      AddStack(*layout, group.settings.Count("quantity"), -scene.world.Real("world.side") / 2,
               *block, blocks);
    if (layout->name == "at") AddPoints(*layout, *block, blocks);
  }
  return blocks;
}

/// Whether a point is over the upper face of the block.
bool IsOver(const Block& block, const Vector3d& point) {
  const Vector3d way = point - block.centre;
  return block.is_round ? std::hypot(way.x(), way.z()) < block.half.x()
                        : std::abs(way.x()) < block.half.x() && std::abs(way.z()) < block.half.z();
}

bool Bears(const Block& lower, const Block& upper) {
  const double gap = upper.centre.y() - lower.centre.y() - lower.half.y() - upper.half.y();
  const double least = 2 * upper.half.minCoeff();
  return IsOver(lower, upper.centre) && gap > -kReach * least && gap <= kFall * least;
}

/// The block with its centre moved to that of the mass of everything that it bears; nullopt if
/// something on it does not stand, or stands on others as well.
std::optional<Block> WithLoad(const Block& block, const std::vector<Block>& all) {
  Block whole = block;
  whole.centre *= block.mass;
  for (const Block& upper : all) {
    if (!Bears(block, upper)) continue;
    if (std::ranges::count_if(all, [&](const Block& lower) { return Bears(lower, upper); }) != 1)
      return std::nullopt;
    const auto load = WithLoad(upper, all);
    if (!load || !IsOver(block, load->centre)) return std::nullopt;
    whole.mass += load->mass;
    whole.centre += load->mass * load->centre;
  }
  whole.centre /= whole.mass;
  // It presses on what is below within its own lower face.
  return IsOver(block, whole.centre) ? std::optional(whole) : std::nullopt;
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
  if (all.size() > kMostBlocks) return false;
  const bool all_are_borne = std::ranges::all_of(own, [&](const Block& upper) {
    return Bears(floor, upper) ||
           std::ranges::any_of(all, [&](const Block& lower) { return Bears(lower, upper); });
  });
  return all_are_borne && std::ranges::all_of(all, [&](const Block& lowest) {
           return !Bears(floor, lowest) || WithLoad(lowest, all).has_value();
         });
}

}  // namespace cdb::analysis
