#include "library/layouts/clearance.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <utility>

#include "compiler/analysis/expectation.h"
#include "compiler/analysis/trace.h"
#include "dsl/text/check.h"
#include "library/layouts/exact_layouts.h"
#include "library/layouts/joint_pairs.h"
#include "library/objects/distance.h"
#include "library/objects/solid_pair.h"
#include "library/scene_error.h"

namespace cdb::layouts {
namespace {

using Eigen::Vector3d;

/// Overlaps below these are attributed to rounding: in units of rounding of the coordinates, and as
/// a fraction of sizes and distance, the accuracy of library/objects/distance.h.
constexpr double kRoundedCoordinates = 8 * std::numeric_limits<double>::epsilon();
constexpr double kRoundedDistance = 4e-14;
/// As a fraction of an object: with more rounding, positions are too coarse to distinguish touching
/// from overlapping, and neither is allowed.
constexpr double kCoarse = 1e-6;
/// As a fraction of both sizes: the separation at which two surfaces show the direction of contact.
constexpr double kShownApart = 1e-6;

/// `reaches 2 m through`, for messages; `extent` is that of the object.
std::string HowFar(double through, double extent, double rounding) {
  if (through <= rounding) return "is closer than the precision of its position to";
  if (through > extent) return fmt::format("lies {:.4g} m beyond", through - extent);
  return fmt::format("reaches {:.4g} m through", through);
}

void CheckWalls(const Bodies& bodies, std::size_t index) {
  const objects::Box box = bodies.BoxOf(index);
  const double half = bodies.side() / 2;
  for (int axis = 0; axis < 3; ++axis) {
    for (const int sign : {-1, 1}) {
      const double through = (sign < 0 ? -box.lower[axis] : box.upper[axis]) - half;
      const double extent = bodies.Extents(index)[axis];
      const double rounding = kRoundedCoordinates * (half + extent);
      if (through < 0 || (through <= rounding && rounding <= kCoarse * extent)) continue;
      throw library::SceneError(
          fmt::format("{} {} the cube's wall {}{}", bodies.Name(index),
                      HowFar(through, extent, rounding), sign < 0 ? '-' : '+', "xyz"[axis]),
          std::string(AdviceOf(bodies.GroupOf(index)).wall), bodies.GroupOf(index).name);
    }
  }
}

/// Recorded objects that lie on a wall penetrate it slightly, as contacts are not rigid.
bool MayReachThroughWalls(const Bodies& bodies, std::size_t index) {
  const plan::Group& group = bodies.GroupOf(index);
  return analysis::PosesOf(group) != nullptr && group.settings.On("overlap") &&
         bodies.core(index).position.cwiseAbs().maxCoeff() < bodies.side() / 2;
}

/// Two objects in their positions.
class PlacedPair {
 public:
  PlacedPair(const ObjectState& a, const ObjectState& b)
      : a_(a),
        b_(b),
        pair_(a.solid, a.pose.orientation, b.solid, b.pose.orientation),
        offset_(b.pose.position - a.pose.position),
        coarseness_(kRoundedCoordinates * (a.pose.position.cwiseAbs().maxCoeff() +
                                           b.pose.position.cwiseAbs().maxCoeff())),
        rounding_(kRoundedDistance * (pair_.size() + offset_.norm()) + coarseness_) {}

  /// True if no two pieces penetrate one another by more than rounding.
  bool OnlyTouches() const {
    const double least = std::min(a_.solid.sides.minCoeff(), b_.solid.sides.minCoeff());
    if (offset_.isZero(0) || coarseness_ > kCoarse * least) return false;
    bool touches = false;
    const bool penetrates = pair_.AnyPieces([&](std::size_t i, std::size_t j) {
      const bool overlaps = pair_.PiecesOverlap(i, j, offset_);
      touches = touches || overlaps;
      return overlaps && !IsFreedByRounding(i, j);
    });
    return !penetrates && (touches || !pair_.IsInCells(offset_));
  }

  /// The distance that b must move away from a, along the line between their centres of mass, to be
  /// separate. m.
  double Depth() const {
    const double apart = offset_.norm();
    const Vector3d direction = apart > 0 ? Vector3d(offset_ / apart) : Vector3d::UnitY();
    const auto free = objects::Approach(a_.solid, a_.pose, b_.solid, b_.pose, direction, rounding_);
    return std::max(free.value_or(apart) - apart, rounding_);
  }

 private:
  /// Moved apart slightly along the line between the centres of mass, two surfaces show the
  /// direction of contact; a displacement by the rounding along it must separate them.
  bool IsFreedByRounding(std::size_t i, std::size_t j) const {
    const Vector3d away = kShownApart * pair_.size() * offset_.normalized();
    const Vector3d direction = pair_.PieceGap(i, j, offset_ + away).direction;
    return !direction.isZero(0) && !pair_.PiecesOverlap(i, j, offset_ + rounding_ * direction);
  }

  const ObjectState &a_, &b_;
  objects::SolidPair pair_;
  Vector3d offset_;
  double coarseness_;  ///< of the coordinates, m
  double rounding_;    ///< including that of distances, m
};

void CheckPair(const Bodies& bodies, std::size_t one, std::size_t two) {
  const auto [other, index] = std::minmax(one, two);
  const PlacedPair pair(bodies.object(other), bodies.object(index));
  if (pair.OnlyTouches()) return;
  const std::string_view advice = bodies.object(index).group == bodies.object(other).group
                                      ? AdviceOf(bodies.GroupOf(index)).overlap
                                      : "give one of the two groups another place";
  throw library::SceneError(
      fmt::format("{} overlaps {} by {:.4g} m along the line between their centres of mass",
                  bodies.Name(index), bodies.Name(other), pair.Depth()),
      std::string(advice), bodies.GroupOf(index).name);
}

}  // namespace

void CheckClearance(const Bodies& bodies, const std::vector<std::uint32_t>& indices) {
  const auto is_fixed = [&](std::uint32_t index) { return bodies.object(index).IsFixed(); };
  std::vector<char> overlaps;  // by group
  for (const GroupRange& range : bodies.groups())
    overlaps.push_back(range.group->settings.On("overlap"));
  const auto may_overlap = [&](std::uint32_t index) {
    return overlaps[bodies.object(index).group] != 0;
  };
  const analysis::Collisions collisions(bodies.scene());
  const auto may_touch = [&](std::uint32_t a, std::uint32_t b) {
    return collisions.MayTouch(bodies.object(a).group, bodies.object(b).group);
  };
  // Joined objects do not collide.
  std::set<std::pair<std::size_t, std::size_t>> joined;
  for (const JointPair& pair : JointPairsOf(bodies.scene()))
    joined.insert(std::minmax(pair.parent, pair.child));
  const auto are_joined = [&](std::size_t a, std::size_t b) {
    return !joined.empty() && joined.contains(std::minmax(a, b));
  };
  std::vector<std::pair<int, std::uint32_t>> by_size;  // the largest first
  by_size.reserve(indices.size());
  for (const std::uint32_t index : indices) {
    if (!is_fixed(index) && !MayReachThroughWalls(bodies, index)) CheckWalls(bodies, index);
    by_size.emplace_back(-HashGrid::LevelOf(bodies.Extents(index).maxCoeff()), index);
  }
  std::ranges::sort(by_size);
  HashGrid grid(indices.size());
  for (const auto& [level, index] : by_size) {
    const objects::Box box = bodies.BoxOf(index);
    grid.AnyOf(box, [&](std::uint32_t other) {
      if (is_fixed(index) && is_fixed(other)) return false;
      if (may_overlap(index) && may_overlap(other)) return false;
      if (!may_touch(index, other) || are_joined(index, other)) return false;
      if (bodies.TouchesAt(index, bodies.core(index).position, box, other))
        CheckPair(bodies, index, other);
      return false;
    });
    grid.Add(index, -level, box);
  }
}

HashGrid::HashGrid(std::size_t boxes) : heads_(std::bit_ceil(2 * boxes + 1), kNone) {
  entries_.reserve(boxes);
}

std::int64_t HashGrid::Cell(double coordinate) {
  // All cells beyond this share one, so that differences do not overflow.
  constexpr double kFar = 0x1p60;
  return static_cast<std::int64_t>(std::floor(std::clamp(coordinate, -kFar, kFar)));
}

std::size_t HashGrid::Bucket(int level, std::int64_t x, std::int64_t y, std::int64_t z) const {
  // Neighbours along x stay neighbours in memory; rows, planes and levels are scattered.
  std::uint64_t row = static_cast<std::uint64_t>(y) * 0x9e3779b97f4a7c15 +
                      static_cast<std::uint64_t>(z) * 0xc2b2ae3d27d4eb4f +
                      static_cast<std::uint64_t>(level) * 0x165667b19e3779f9;
  row ^= row >> 32;
  return (row + static_cast<std::uint64_t>(x)) & (heads_.size() - 1);
}

void HashGrid::Add(std::uint32_t id, int level, const objects::Box& box) {
  if (levels_.empty() || levels_.back() != level) {
    CDB_CHECK(levels_.empty() || levels_.back() > level);
    levels_.push_back(level);
  }
  const Eigen::Vector3d centre = (box.lower + box.upper) / (2 * std::ldexp(1.0, level));
  std::uint32_t& head = heads_[Bucket(level, Cell(centre.x()), Cell(centre.y()), Cell(centre.z()))];
  entries_.push_back({id, head});
  head = static_cast<std::uint32_t>(entries_.size() - 1);
}

namespace {

/// The maximum number of entries per box. Compact boxes that fit into the cube stay below it with
/// one cell per box; long thin oblique ones need larger cells.
constexpr double kMaxEntriesPerBox = 32;
constexpr double kMaxCellsAlongEdge = 1024;

}  // namespace

BoxGrid::BoxGrid(double side, const std::vector<double>& extents) : side_(side) {
  const double count = static_cast<double>(extents.size());
  double cells = std::clamp(std::floor(std::cbrt(count)), 1.0, kMaxCellsAlongEdge);
  double entries = count;
  for (; cells > 1; cells = std::floor(cells / 2)) {
    entries = 0;
    for (const double extent : extents) {
      const double along = std::min(extent * cells / side + 1, cells);
      entries += along * along * along;
    }
    if (entries <= kMaxEntriesPerBox * count) break;
  }
  if (cells <= 1) entries = count;
  cells_ = static_cast<std::size_t>(cells);
  cells_per_metre_ = cells / side;
  heads_.assign(cells_ * cells_ * cells_, kNone);
  // The number for cubes of these extents: growing the vector would copy the entries repeatedly.
  entries_.reserve(static_cast<std::size_t>(entries));
}

BoxGrid::Bounds32 BoxGrid::Outwards(const objects::Box& box) const {
  // Coordinates are at most 1 here, so rounding twice loses up to 2^-24. Larger ones are outside
  // the cube, and so outside any query.
  constexpr float kLarger = 0x1p-23F;
  const auto in_sides = [&](double x) {
    return static_cast<float>(std::clamp(x / side_, -1., 1.));
  };
  Bounds32 bounds;
  for (int axis = 0; axis < 3; ++axis) {
    bounds.lower[axis] = in_sides(box.lower[axis]) - kLarger;
    bounds.upper[axis] = in_sides(box.upper[axis]) + kLarger;
  }
  return bounds;
}

std::size_t BoxGrid::Cell(double coordinate) const {
  const double cell = (coordinate + side_ / 2) * cells_per_metre_;
  if (!(cell > 0)) return 0;
  return std::min(static_cast<std::size_t>(cell), cells_ - 1);
}

void BoxGrid::Add(std::uint32_t id, const objects::Box& box) {
  const Bounds32 bounds = Outwards(box);
  AnyCell(box, [&](std::size_t cell) {
    entries_.push_back({bounds, id, heads_[cell]});
    heads_[cell] = static_cast<std::uint32_t>(entries_.size() - 1);
    return false;
  });
}

}  // namespace cdb::layouts
