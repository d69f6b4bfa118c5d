// Places every object according to its layout, so that it neither reaches through a wall nor into
// another object.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/plan/plan.h"
#include "library/layouts/bodies.h"
#include "library/layouts/clearance.h"
#include "library/layouts/initial_state.h"
#include "library/layouts/region.h"
#include "library/objects/solid.h"

namespace cdb::layouts {

/// The maximum number of draws for one object, and for all together. Tested voxels count as draws.
inline constexpr std::uint64_t kMaxTriesOfOne = 100000;
inline constexpr std::uint64_t kMinTriesOfAll = 1000000;
inline constexpr std::uint64_t kMeanTriesOfAll = 1000;  ///< per object

/// Up to this packing fraction (of boxes around shapes other than balls), positions are drawn up to
/// kMaxTriesOfOne times; beyond it, an object that failed kMissesBeforeVoxels times in a row is
/// placed by means of the voxels.
inline constexpr double kMaxPlainFill = 0.25;
/// Beyond this, objects of a normal layout may find no position near the centre.
inline constexpr double kMaxNormalFill = 0.01;
inline constexpr std::uint64_t kMissesBeforeVoxels = 1000;

/// Packing fractions of equal solids at which random sequential addition ends: slightly above .3841
/// for balls (Zhang and Torquato 2013) and .4227 for aligned cubes, the densest of the other
/// shapes. They hold for many objects that are small compared with the cube; a group of those that
/// needs more is rejected before the first draw.
inline constexpr double kMaxFillOfBalls = 0.40;
inline constexpr double kMaxFillOfOthers = 0.45;
inline constexpr std::uint64_t kManyObjects = 1000;
inline constexpr double kShortOfSide = 0.25;

/// Sets the position of every object of `state`: first, in order, of the groups whose layout
/// defines each position (library/layouts/exact_layouts.h), then, in order, of those drawn around
/// them, from the stream `<group>.location`:
///   uniform  each coordinate uniform over the range in which the object fits into its region
///            (library/layouts/region.h) and between the walls: "uniform over the cube" with
///            positions that touch a wall redrawn
///   normal   each coordinate normal about the centre of the region with a sixth of its extent as
///            standard deviation, redrawn until it fits
/// An object that stands has a height drawn uniformly from that of half to one and a half gaps.
/// No object overlaps another one of any group, or a wall of the cube, whichever walls are in use;
/// but fixed objects of exact layouts may leave the cube and overlap one another, so that obstacles
/// and floors can be built from them. Objects of exact layouts may touch. A drawn position that
/// touches an object is redrawn. Boxes are compared first, by a grid with a cell for each object,
/// then the solids: O(N) unless the cube is crowded.
///
/// In a crowded cube, uniform positions are drawn from the voxels that still contain a free one
/// (library/layouts/clearance.h), which does not change the distribution. So equal solids are
/// placed as long as there is a free position, and its absence is proven. A normal layout is only
/// redrawn: its voxels would need weights, and it crowds at the centre long before the cube is
/// full.
///
/// Objects that come later have no position: NaN.
///
/// Throws SceneError if an exact layout does not take this number of objects or gives an invalid
/// position, with the amount and a remedy (library/layouts/clearance.h). Throws it, with the
/// packing fraction, the fraction already filled and a remedy, if a drawn object is larger than the
/// cube, no free position is left, the objects can never fit, or the limits above are reached; so
/// it always terminates. One thread; the same result on every machine, except that the last bit of
/// a ring depends on std::sin and std::cos.
void Place(const plan::Scene& scene, InitialState& state);

/// Throws the SceneErrors of Place and of CheckRange. Positions are drawn only if the cube is
/// crowded, so that they may not be found, and only `draws` of them, which it reduces: if they do
/// not suffice, no error is thrown. O(N) otherwise.
void CheckPlacement(const plan::Scene& scene, std::uint64_t& draws);

// Finds voxels that are certainly occupied.

/// The object for which voxels are tested: a solid that is contained in every object still to be
/// placed, at its centre of mass. A position that is not free for the probe is free for none of
/// them.
struct Probe {
  objects::Solid solid;
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  objects::Box bounds;          ///< with its centre of mass at the origin
  double inner = 0, outer = 0;  ///< radii, m

  Probe(objects::Solid its_solid, const Eigen::Quaterniond& its_orientation);
};

/// `bodies`, and the grid, which lists the placed ones, must outlive it. Not thread-safe.
class Coverage {
 public:
  Coverage(const Bodies& bodies, const BoxGrid& grid) : bodies_(bodies), grid_(grid) {}

  /// Whether the probe touches object `other` at every position in the voxel.
  bool Covers(std::uint32_t other, const Probe& probe, const objects::Box& voxel) const;
  /// Whether the probe is known to touch an object at every position in the voxel.
  bool IsCovered(const Probe& probe, const objects::Box& voxel) const;

 private:
  bool IsCoveredBySlabs(const Probe& probe, const objects::Box& voxel) const;

  const Bodies& bodies_;
  const BoxGrid& grid_;
};

// The packing fraction of the cube, and the errors that report it.

/// Objects of exact layouts must already be placed; only the part of their boxes inside the cube
/// counts. The bodies must outlive it. Not thread-safe.
class PackingFraction {
 public:
  explicit PackingFraction(const Bodies& bodies);

  /// m^3: the volume of the cube, and of all objects: of balls themselves, and of the boxes around
  /// others.
  double Cube() const { return bodies_.side() * bodies_.side() * bodies_.side(); }
  double balls_and_boxes() const { return balls_and_boxes_; }
  /// Whether random positions may not be found although RefuseWhatCannotFit does not throw.
  bool IsCrowded() const;

  /// Throws SceneError if drawn layouts can never succeed: an object is larger than its region, all
  /// objects together are larger than the cube, or the equal objects of a group exceed the limit of
  /// random placement. Groups with a region at another group are left out.
  void RefuseWhatCannotFit() const;
  /// The first and the last of these for one group, whose region is known.
  void RefuseWhatCannotFit(const GroupRange& range, const Region& region) const;
  /// Counts object `index`, which has been placed.
  void CountPlaced(std::size_t index) { placed_volume_ += bodies_.object(index).solid.Volume(); }

  static constexpr std::string_view kGivenUp = "every position drawn was taken";
  static constexpr std::string_view kNoPlaceLeft = "no free position was left";
  [[noreturn]] void TooFull(std::size_t index, const Region& region, std::string_view when) const;

 private:
  void RefuseLarge(const GroupRange& range, const Region& region) const;
  void RefuseGroup(const GroupRange& range, const Region& region) const;
  /// The fraction of its box that is inside the cube.
  double PartInside(std::size_t index) const;
  std::string Advice() const;

  const Bodies& bodies_;
  double volume_ = 0, placed_volume_ = 0, boxes_ = 0, balls_and_boxes_ = 0;  ///< m^3
};

// Random layouts, which redraw each position until it is free: uniform, normal.

/// The draws that missed, and tested voxels, until placement gives up.
constexpr std::uint64_t MostTries(std::size_t objects) {
  return kMinTriesOfAll + kMeanTriesOfAll * objects;
}

/// Places the objects of all groups with such layouts, in order, around the objects already placed:
/// all those of exact layouts, inside the cube or not. Positions, errors:
/// library/layouts/placement.h. Gives up after `tries`, which it reduces by those made.
void PlaceDrawn(const plan::Scene& scene, Bodies& bodies, std::uint64_t& tries);

// Remembers which objects blocked earlier draws, by position.

inline constexpr std::uint32_t kNobody = std::numeric_limits<std::uint32_t>::max();

/// The last object that blocked a draw in each cell of a fine grid, so that most failed draws test
/// only one object. It may forget or be wrong: it only determines which object is tested first. Not
/// thread-safe.
class Hints {
 public:
  Hints(double side, std::size_t objects) : half_side_(side / 2) {
    const double along =
        std::clamp(std::floor(2 * std::cbrt(static_cast<double>(objects))), 1.0, double{kMaxAlong});
    along_ = static_cast<std::size_t>(along);
    per_metre_ = along / side;
    ids_.assign(along_ * along_ * along_, kNobody);
  }

  std::uint32_t At(const Eigen::Vector3d& place) const {
    return ids_[(Cell(place.x()) * along_ + Cell(place.y())) * along_ + Cell(place.z())];
  }

  void Set(const objects::Box& box, std::uint32_t id) {
    for (std::size_t x = Cell(box.lower.x()); x <= Cell(box.upper.x()); ++x)
      for (std::size_t y = Cell(box.lower.y()); y <= Cell(box.upper.y()); ++y)
        for (std::size_t z = Cell(box.lower.z()); z <= Cell(box.upper.z()); ++z)
          ids_[(x * along_ + y) * along_ + z] = id;
  }

 private:
  static constexpr std::size_t kMaxAlong = 512;  ///< 0.5 GB
  std::size_t Cell(double coordinate) const {
    const double cell = (coordinate + half_side_) * per_metre_;
    if (!(cell > 0)) return 0;
    return std::min(static_cast<std::size_t>(cell), along_ - 1);
  }

  double half_side_, per_metre_;
  std::size_t along_;
  std::vector<std::uint32_t> ids_;
};

}  // namespace cdb::layouts
