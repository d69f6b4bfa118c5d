#include "library/layouts/placement.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "compiler/analysis/population.h"
#include "dsl/text/check.h"
#include "library/distributions/draw.h"
#include "library/layouts/bodies.h"
#include "library/layouts/clearance.h"
#include "library/layouts/emitter.h"
#include "library/layouts/exact_layouts.h"
#include "library/layouts/number_range.h"
#include "library/objects/solid_pair.h"
#include "library/scene_error.h"

namespace cdb::layouts {
namespace {

/// Places the groups with exact layouts. False if there are no groups to be drawn.
bool PlaceStanding(const plan::Scene& scene, Bodies& bodies) {
  std::vector<std::uint32_t> standing;
  for (const GroupRange& range : bodies.groups()) {
    if (!HasExactLayout(*range.group)) continue;
    PlaceExactly(scene, range, bodies);
    for (std::size_t i = range.first; i < range.end; ++i)
      standing.push_back(static_cast<std::uint32_t>(i));
  }
  CheckClearance(bodies, standing);
  return standing.size() < bodies.size();
}

bool Spawns(const plan::Scene& scene) {
  return std::ranges::any_of(scene.groups, [](const plan::Group& group) {
    return analysis::SpawningOf(group) && group.settings.Count("quantity") > 0;
  });
}

/// The scene with those objects that are there at the start.
plan::Scene WithoutSpawned(const plan::Scene& scene) {
  plan::Scene at_start = scene;
  for (plan::Group& group : at_start.groups)
    if (analysis::SpawningOf(group))
      group.settings.Set("quantity", schema::Number(std::uint64_t{0}));
  return at_start;
}

/// Moves the objects that are there at the start out of `state`.
InitialState WithoutSpawned(const plan::Scene& scene, InitialState& state) {
  InitialState there;
  there.forms = state.forms;
  there.acceleration = state.acceleration;
  for (ObjectState& object : state.objects)
    if (!analysis::SpawningOf(scene.groups[object.group]))
      there.objects.push_back(std::move(object));
  return there;
}

/// Moves them back, and takes the positions of the others.
void PutBack(const plan::Scene& scene, InitialState there, InitialState& state) {
  auto next = there.objects.begin();
  std::size_t index = 0;
  for (std::size_t group = 0; group < scene.groups.size(); ++group) {
    const bool spawns = analysis::SpawningOf(scene.groups[group]).has_value();
    for (std::uint64_t i = scene.groups[group].settings.Count("quantity"); i > 0; --i, ++index) {
      if (spawns) {
        state.objects[index].pose.position.setConstant(std::numeric_limits<double>::quiet_NaN());
      } else {
        state.objects[index] = std::move(*next++);
      }
    }
  }
}

}  // namespace

void Place(const plan::Scene& scene, InitialState& state) {
  if (Spawns(scene)) {
    CheckEmitters(scene, state);
    const plan::Scene at_start = WithoutSpawned(scene);
    InitialState there = WithoutSpawned(scene, state);
    Place(at_start, there);
    PutBack(scene, std::move(there), state);
    return;
  }
  Bodies bodies(scene, state);
  std::uint64_t tries = MostTries(bodies.size());
  if (PlaceStanding(scene, bodies)) PlaceDrawn(scene, bodies, tries);
}

void CheckPlacement(const plan::Scene& scene, std::uint64_t& draws) {
  InitialState state = DrawObjects(scene);
  if (Spawns(scene)) {
    CheckEmitters(scene, state);
    CheckRange(scene, state);
    return CheckPlacement(WithoutSpawned(scene), draws);
  }
  Bodies bodies(scene, state);
  const bool are_all_placed = !PlaceStanding(scene, bodies);
  CheckRange(scene, state);
  if (are_all_placed) return;
  const PackingFraction fraction(bodies);
  fraction.RefuseWhatCannotFit();
  if (!fraction.IsCrowded()) return;
  const std::uint64_t most = std::min(draws, MostTries(bodies.size()));
  std::uint64_t left = most;
  const auto give_back = [&] { draws -= most - left; };
  try {
    PlaceDrawn(scene, bodies, left);
    give_back();
  } catch (const library::SceneError&) {
    give_back();
    if (left > 0 || most == MostTries(bodies.size())) throw;
  }
}

namespace {

using Eigen::Vector3d;

bool IsUnturnedCuboid(const objects::Solid& solid, const Eigen::Quaterniond& orientation) {
  return solid.shape == objects::Shape::kCuboid &&
         orientation.coeffs() == Eigen::Quaterniond::Identity().coeffs();
}

}  // namespace

Probe::Probe(objects::Solid its_solid, const Eigen::Quaterniond& its_orientation)
    : solid(std::move(its_solid)),
      orientation(its_orientation),
      bounds(objects::Bounds(solid, orientation)),
      inner(solid.InnerRadius()),
      outer(solid.OuterRadius()) {}

bool Coverage::Covers(std::uint32_t other, const Probe& probe, const objects::Box& voxel) const {
  // A surface is too thin to cover a position.
  if (bodies_.object(other).solid.IsSurface()) return false;
  const Core& theirs = bodies_.core(other);
  const Vector3d to_lower = (theirs.position - voxel.lower).cwiseAbs();
  const Vector3d to_upper = (theirs.position - voxel.upper).cwiseAbs();
  const double farthest = to_lower.cwiseMax(to_upper).squaredNorm();
  const double inner = probe.inner + theirs.inner;
  if (farthest < inner * inner * (1 - kRounding) && probe.inner > 0 && theirs.inner > 0)
    return true;
  const double outer = probe.outer + theirs.outer;
  if (farthest > outer * outer * (1 + kRounding)) return false;
  std::array<Vector3d, 8> offsets;  // from the probe in each corner of the voxel
  for (int corner = 0; corner < 8; ++corner)
    for (int axis = 0; axis < 3; ++axis)
      offsets[corner][axis] = theirs.position[axis] -
                              ((corner >> axis & 1) != 0 ? voxel.upper[axis] : voxel.lower[axis]);
  const ObjectState& neighbour = bodies_.object(other);
  const objects::SolidPair pair(probe.solid, probe.orientation, neighbour.solid,
                                neighbour.pose.orientation);
  // The positions at which two convex pieces touch form a convex set, so the corners decide.
  return pair.AnyPieces([&](std::size_t piece, std::size_t their_piece) {
    return std::ranges::all_of(offsets, [&](const Vector3d& offset) {
      return pair.PiecesOverlap(piece, their_piece, offset);
    });
  });
}

bool Coverage::IsCovered(const Probe& probe, const objects::Box& voxel) const {
  // An object that covers the voxel also covers its centre.
  const objects::Box box = Shifted(probe.bounds, (voxel.lower + voxel.upper) / 2);
  if (grid_.AnyOf(box, [&](std::uint32_t other) { return Covers(other, probe, voxel); }))
    return true;
  return IsUnturnedCuboid(probe.solid, probe.orientation) && IsCoveredBySlabs(probe, voxel);
}

/// Whether unrotated cuboids together cover the voxel, cut off slice by slice. Two of them with
/// slightly too little space for the probe between their faces cover many voxels together but none
/// alone, until the voxels are as thin as the missing space.
bool Coverage::IsCoveredBySlabs(const Probe& probe, const objects::Box& voxel) const {
  objects::Box left = voxel;
  const objects::Box reach{voxel.lower + probe.bounds.lower, voxel.upper + probe.bounds.upper};
  const auto cut = [&](std::uint32_t other) {
    const ObjectState& neighbour = bodies_.object(other);
    if (!IsUnturnedCuboid(neighbour.solid, neighbour.pose.orientation)) return false;
    const objects::Box theirs = bodies_.BoxOf(other);
    const Vector3d lower = theirs.lower - probe.bounds.upper;
    const Vector3d upper = theirs.upper - probe.bounds.lower;
    const auto spans = [&](int axis) {
      return lower[axis] <= left.lower[axis] && upper[axis] >= left.upper[axis];
    };
    for (int axis = 0; axis < 3; ++axis) {
      if (!spans((axis + 1) % 3) || !spans((axis + 2) % 3)) continue;
      if (spans(axis)) return true;
      if (lower[axis] <= left.lower[axis])
        left.lower[axis] = std::max(left.lower[axis], upper[axis]);
      if (upper[axis] >= left.upper[axis])
        left.upper[axis] = std::min(left.upper[axis], lower[axis]);
    }
    return false;
  };
  // After a cut, a cuboid may span the rest that did not before.
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round)
    if (grid_.AnyOf(reach, cut)) return true;
  return false;
}

PackingFraction::PackingFraction(const Bodies& bodies) : bodies_(bodies) {
  for (const GroupRange& range : bodies.groups()) {
    const bool stands = HasExactLayout(*range.group);
    for (std::size_t i = range.first; i < range.end; ++i) {
      const objects::Solid& solid = bodies.object(i).solid;
      if (solid.IsSurface()) continue;  // it has no volume
      const double part = stands ? PartInside(i) : 1;
      const double volume = part * solid.Volume(), box = part * bodies.Extents(i).prod();
      volume_ += volume;
      if (stands) placed_volume_ += volume;
      boxes_ += box;
      balls_and_boxes_ += solid.IsBall() ? volume : box;
    }
  }
}

double PackingFraction::PartInside(std::size_t index) const {
  const objects::Box box = bodies_.BoxOf(index);
  const Vector3d half = Vector3d::Constant(bodies_.side() / 2);
  const Vector3d inside = box.upper.cwiseMin(half) - box.lower.cwiseMax(-half);
  return inside.cwiseMax(0).cwiseQuotient(box.upper - box.lower).prod();
}

void PackingFraction::RefuseWhatCannotFit() const {
  const auto for_each = [&](auto refuse) {
    for (const GroupRange& range : bodies_.groups())
      if (!HasExactLayout(*range.group) && GroupOfRegion(*range.group).empty())
        (this->*refuse)(range, RegionOf(bodies_, range));
  };
  for_each(&PackingFraction::RefuseLarge);
  if (volume_ / Cube() > 1) {
    throw library::SceneError(
        fmt::format("all objects together would fill {:.4g} % of the cube, so none was placed",
                    100 * volume_ / Cube()),
        Advice());
  }
  for_each(&PackingFraction::RefuseGroup);
}

void PackingFraction::RefuseWhatCannotFit(const GroupRange& range, const Region& region) const {
  RefuseLarge(range, region);
  RefuseGroup(range, region);
}

bool PackingFraction::IsCrowded() const {
  return std::ranges::any_of(bodies_.groups(), [&](const GroupRange& range) {
    if (HasExactLayout(*range.group) || range.size() == 0) return false;
    if (range.group->settings.Get("region") != schema::Value(schema::Word{"cube"})) return true;
    const bool is_normal = range.group->settings.WordOr("location") == "normal";
    return balls_and_boxes_ > (is_normal ? kMaxNormalFill : kMaxPlainFill) * Cube();
  });
}

void PackingFraction::RefuseLarge(const GroupRange& range, const Region& region) const {
  for (std::size_t i = range.first; i < range.end; ++i) {
    const objects::Box domain = DomainOf(region, bodies_.side(), bodies_.bounds(i));
    for (int axis = 0; axis < 3; ++axis) {
      if (domain.lower[axis] < domain.upper[axis]) continue;
      const bool is_cube = region.is_cube;
      throw library::SceneError(
          fmt::format("{} is {:.6g} m long along {} and does not fit {} {:.6g} m {}",
                      bodies_.Name(i), bodies_.Extents(i)[axis], "xyz"[axis],
                      is_cube ? "between walls" : "into its region, which has",
                      domain.upper[axis] - domain.lower[axis] + bodies_.Extents(i)[axis],
                      is_cube ? "apart" : "there"),
          is_cube ? "make world.side larger or the size smaller"
                  : "make the region larger or the size smaller",
          bodies_.GroupOf(i).name);
    }
  }
}

void PackingFraction::RefuseGroup(const GroupRange& range, const Region& region) const {
  if (range.size() < kManyObjects) return;
  const objects::Solid& solid = bodies_.object(range.first).solid;
  for (std::size_t i = range.first; i < range.end; ++i) {
    if (bodies_.object(i).solid != solid) return;
    if (bodies_.Extents(i).maxCoeff() > kShortOfSide * region.Extents().minCoeff()) return;
  }
  const double most = solid.IsBall() ? kMaxFillOfBalls : kMaxFillOfOthers;
  const double fill = static_cast<double>(range.size()) * solid.Volume() / region.Volume();
  if (fill <= most || region.stands) return;
  throw library::SceneError(
      fmt::format("the {} objects of group `{}` fill {:.3g} % of the {}: equal objects at random "
                  "positions leave no free position before {:.3g} %, so none was placed",
                  range.size(), range.group->name, 100 * fill, region.is_cube ? "cube" : "region",
                  100 * most),
      Advice(), range.group->name);
}

std::string PackingFraction::Advice() const {
  // Boxes that fill a tenth of the cube leave enough space for random placement, whatever the
  // shapes.
  return fmt::format(
      "make world.side larger ({:.4g} m is enough), or the size or the quantity smaller",
      std::max(bodies_.side() * 1.1, std::cbrt(boxes_ * 10)));
}

void PackingFraction::TooFull(std::size_t index, const Region& region,
                              std::string_view when) const {
  const std::string& group = bodies_.GroupOf(index).name;
  if (!region.IsDefault()) {
    double needed = 0;
    for (std::size_t i = 0; i < bodies_.size(); ++i)
      if (bodies_.GroupOf(i).name == group)
        needed += bodies_.Extents(i).prod() / (region.stands ? bodies_.Extents(i).y() : 1);
    const double whole = region.Volume() / (region.stands ? region.Extents().y() : 1);
    throw library::SceneError(
        fmt::format(
            "no free position was found for {} in its region, of {:.4g} x {:.4g} x {:.4g} m, "
            "where {}; the boxes around the objects of its group would fill {:.3g} % of {}",
            bodies_.Name(index), region.Extents().x(), region.Extents().y(), region.Extents().z(),
            when, 100 * needed / whole, region.stands ? "its floor" : "it"),
        "make the region larger, or the size or the quantity smaller", group);
  }
  throw library::SceneError(
      fmt::format(
          "no free position was found for {}: all objects together fill {:.3g} % of the cube "
          "({:.3g} % with the boxes around them), {:.3g} % was filled when {}",
          bodies_.Name(index), 100 * volume_ / Cube(), 100 * boxes_ / Cube(),
          100 * placed_volume_ / Cube(), when),
      Advice(), group);
}

namespace {

constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();

/// Voxels per object of the scene: in a new lattice, and in a list that may still be split.
constexpr double kVoxelsPerObject = 32;
constexpr double kMinVoxels = 1 << 16;
constexpr std::size_t kSplitVoxelsPerObject = 8;
constexpr std::size_t kMinSplitVoxels = 1 << 19;

/// Below this packing fraction, few draws miss.
constexpr double kMinFillForHints = 0.05;
/// In units of the inner radius.
constexpr double kHintReach = 1.0;

std::vector<double> ExtentsOf(const Bodies& bodies) {
  std::vector<double> extents;
  extents.reserve(bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) extents.push_back(bodies.Extents(i).maxCoeff());
  return extents;
}

struct VoxelSearch {
  Probe probe;
  bool exact;  ///< the probe equals each of the remaining objects
  FreeVoxels voxels;
  std::uint64_t misses = 0;  ///< of all objects since the voxels were last split
};

class DrawnPlacer {
 public:
  DrawnPlacer(const plan::Scene& scene, Bodies& bodies, std::uint64_t& tries)
      : scene_(scene),
        bodies_(bodies),
        side_(bodies.side()),
        fraction_(bodies),
        grid_(side_, ExtentsOf(bodies)),
        coverage_(bodies, grid_),
        tries_left_(tries) {
    const double fill = fraction_.balls_and_boxes(), cube = fraction_.Cube();
    if (fill > kMinFillForHints * cube) hints_ = std::make_unique<Hints>(side_, bodies.size());
    misses_before_voxels_ = fill <= kMaxPlainFill * cube ? kMaxTriesOfOne : kMissesBeforeVoxels;
  }

  void PlaceAll() {
    fraction_.RefuseWhatCannotFit();
    for (const GroupRange& range : bodies_.groups())
      if (HasExactLayout(*range.group))
        for (std::size_t i = range.first; i < range.end; ++i) List(i);
    for (const GroupRange& range : bodies_.groups())
      if (!HasExactLayout(*range.group) && range.size() > 0) PlaceGroup(range);
  }

 private:
  void PlaceGroup(const GroupRange& range) {
    region_ = RegionOf(bodies_, range);
    if (!GroupOfRegion(*range.group).empty()) fraction_.RefuseWhatCannotFit(range, region_);
    const std::string_view layout = range.group->settings.WordOr("location");
    CDB_CHECK(layout == "uniform" || layout == "normal");
    distributions::Stream stream =
        distributions::NamedStream(scene_, range.group->name, "location");
    if (layout == "normal") {
      PlaceNormal(range, stream);
    } else {
      PlaceUniform(range, stream);
    }
  }

  /// The open box for the centre of mass that keeps the object in its region.
  objects::Box DomainOf(std::size_t index) const {
    return layouts::DomainOf(region_, side_, bodies_.bounds(index));
  }

  void PlaceNormal(const GroupRange& range, distributions::Stream& stream) {
    for (std::size_t index = range.first; index < range.end; ++index) {
      const auto draw_along = [&](int axis, double low, double high) {
        if (region_.stands && axis == 1) return stream.Uniform(low, high);
        return region_.Centre()[axis] + region_.Extents()[axis] / 6 * stream.Normal();
      };
      if (!PlacePlainly(index, kMaxTriesOfOne, draw_along))
        fraction_.TooFull(index, region_, PackingFraction::kGivenUp);
    }
  }

  void PlaceUniform(const GroupRange& range, distributions::Stream& stream) {
    const auto draw_along = [&](int, double low, double high) { return stream.Uniform(low, high); };
    std::optional<VoxelSearch> search;
    for (std::size_t index = range.first; index < range.end; ++index) {
      if (!search) {
        if (PlacePlainly(index, region_.is_cube ? misses_before_voxels_ : kMissesBeforeVoxels,
                         draw_along))
          continue;
        search.emplace(SearchFor(index, range.end));
      }
      const std::uint64_t max_misses = search->exact ? kNoLimit : kMissesBeforeVoxels;
      if (PlaceInVoxels(index, *search, max_misses, stream)) continue;
      // The voxels are free for a smaller probe: find those of this object.
      VoxelSearch own = SearchFor(index, index + 1);
      PlaceInVoxels(index, own, kNoLimit, stream);
    }
  }

  template <typename DrawAlong>
  bool PlacePlainly(std::size_t index, std::uint64_t max_misses, DrawAlong draw_along) {
    const objects::Box domain = DomainOf(index);
    for (std::uint64_t misses = 0; misses < max_misses; ++misses) {
      Vector3d place;
      for (int axis = 0; axis < 3; ++axis)
        place[axis] = Coordinate(index, axis, domain, draw_along);
      if (ColliderAt(index, place) == kNobody) {
        Settle(index, place);
        return true;
      }
      CountTry(index);
    }
    return false;
  }

  /// A coordinate strictly within the domain. The axes are independent, so redrawing one
  /// coordinate gives the same distribution as redrawing the whole position.
  template <typename DrawAlong>
  double Coordinate(std::size_t index, int axis, const objects::Box& domain, DrawAlong draw_along) {
    const double low = domain.lower[axis], high = domain.upper[axis];
    for (std::uint64_t tries = 0; tries < kMaxTriesOfOne; ++tries) {
      const double x = draw_along(axis, low, high);
      if (x > low && x < high) return x;
      CountTry(index);
    }
    fraction_.TooFull(index, region_, PackingFraction::kGivenUp);
  }

  /// The voxels that are free for the objects in [first, end): for the object itself if all are
  /// equal, otherwise for the largest ball inside each of them.
  VoxelSearch SearchFor(std::size_t first, std::size_t end) {
    const ObjectState& object = bodies_.object(first);
    bool alike = true;
    double radius = object.solid.InnerRadius(), half = object.solid.LeastHalfExtent();
    objects::Box domain = DomainOf(first);
    for (std::size_t i = first + 1; i < end; ++i) {
      const ObjectState& other = bodies_.object(i);
      alike = alike && other.solid == object.solid &&
              (object.solid.IsBall() ||
               other.pose.orientation.coeffs() == object.pose.orientation.coeffs());
      radius = std::min(radius, other.solid.InnerRadius());
      half = std::min(half, other.solid.LeastHalfExtent());
      const objects::Box other_domain = DomainOf(i);
      domain.lower = domain.lower.cwiseMin(other_domain.lower);
      domain.upper = domain.upper.cwiseMax(other_domain.upper);
    }
    const Probe probe = alike ? Probe(object.solid, object.pose.orientation)
                              : Probe({objects::Shape::kEllipsoid, Vector3d::Constant(2 * radius)},
                                      object.pose.orientation);
    const double most = kMinVoxels + kVoxelsPerObject * static_cast<double>(bodies_.size());
    const auto covered = [&](const objects::Box& voxel) { return IsCovered(probe, voxel, first); };
    // The centre of mass of a ring is in none of its pieces.
    const double edge = radius > 0 ? radius : half;
    FreeVoxels voxels(domain.lower, domain.upper, edge, most, covered);
    return {probe, alike, std::move(voxels)};
  }

  /// False if `max_misses` draws in a row were not free. Throws SceneError if no voxel is left.
  bool PlaceInVoxels(std::size_t index, VoxelSearch& search, std::uint64_t max_misses,
                     distributions::Stream& stream) {
    const objects::Box domain = DomainOf(index);
    for (std::uint64_t misses = 0; misses < max_misses; ++misses) {
      FreeVoxels& voxels = search.voxels;
      if (voxels.empty()) fraction_.TooFull(index, region_, PackingFraction::kNoPlaceLeft);
      const double count = static_cast<double>(voxels.size());
      // The product may round up to the count.
      const std::size_t drawn =
          std::min(static_cast<std::size_t>(count * stream.Uniform()), voxels.size() - 1);
      const objects::Box voxel = voxels.BoxOf(drawn);
      Vector3d place;
      for (int axis = 0; axis < 3; ++axis)
        place[axis] = stream.Uniform(voxel.lower[axis], voxel.upper[axis]);
      const bool fits = (place.array() > domain.lower.array()).all() &&
                        (place.array() < domain.upper.array()).all();
      const std::uint32_t collider = fits ? ColliderAt(index, place) : kNobody;
      if (fits && collider == kNobody) {
        Settle(index, place);
        return true;
      }
      CountTry(index);
      if (fits && coverage_.Covers(collider, search.probe, voxel)) voxels.Remove(drawn);
      // After two draws per voxel, nearly all voxels covered by a single object have been found.
      if (++search.misses < 2 * voxels.size()) continue;
      if (voxels.size() > kMinSplitVoxels + kSplitVoxelsPerObject * bodies_.size()) continue;
      if (!voxels.CanSplit()) fraction_.TooFull(index, region_, PackingFraction::kGivenUp);
      voxels.Split([&](const objects::Box& part) { return IsCovered(search.probe, part, index); });
      search.misses = 0;
    }
    return false;
  }

  /// An object that the object would touch at `place`, or kNobody.
  std::uint32_t ColliderAt(std::size_t index, const Vector3d& place) {
    std::uint32_t collider = hints_ ? hints_->At(place) : kNobody;
    const objects::Box box = Shifted(bodies_.bounds(index), place);
    if (collider != kNobody && bodies_.TouchesAt(index, place, box, collider)) return collider;
    collider = kNobody;
    grid_.AnyOf(box, [&](std::uint32_t other) {
      if (!bodies_.TouchesAt(index, place, box, other)) return false;
      collider = other;
      return true;
    });
    if (hints_ && collider != kNobody) hints_->Set({place, place}, collider);
    return collider;
  }

  /// `index` is the object for which the voxel is tested.
  bool IsCovered(const Probe& probe, const objects::Box& voxel, std::size_t index) {
    CountTry(index);
    return coverage_.IsCovered(probe, voxel);
  }

  void Settle(std::size_t index, const Vector3d& place) {
    bodies_.MoveTo(index, place);
    fraction_.CountPlaced(index);
    List(index);
  }

  /// Adds it to the grid, so that later objects avoid it.
  void List(std::size_t index) {
    const auto id = static_cast<std::uint32_t>(index);
    grid_.Add(id, bodies_.BoxOf(index));
    if (!hints_) return;
    // Later objects are likely to be as large, and to touch it from these positions.
    const Core& core = bodies_.core(index);
    const Vector3d reach = Vector3d::Constant(kHintReach * core.inner);
    hints_->Set({core.position - reach, core.position + reach}, id);
  }

  void CountTry(std::size_t index) {
    if (tries_left_ == 0) fraction_.TooFull(index, region_, PackingFraction::kGivenUp);
    --tries_left_;
  }

  const plan::Scene& scene_;
  Bodies& bodies_;
  double side_;
  Region region_;  ///< of the group being placed
  PackingFraction fraction_;
  BoxGrid grid_;
  Coverage coverage_;
  std::unique_ptr<Hints> hints_;  ///< null in a sparse cube
  std::uint64_t& tries_left_;
  std::uint64_t misses_before_voxels_ = 0;
};

}  // namespace

void PlaceDrawn(const plan::Scene& scene, Bodies& bodies, std::uint64_t& tries) {
  DrawnPlacer(scene, bodies, tries).PlaceAll();
}

}  // namespace cdb::layouts
