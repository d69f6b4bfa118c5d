#include "library/layouts/drawn_layouts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "dsl/text/check.h"
#include "library/distributions/draw.h"
#include "library/layouts/coverage.h"
#include "library/layouts/exact_layouts.h"
#include "library/layouts/free_voxels.h"
#include "library/layouts/grid.h"
#include "library/layouts/hints.h"
#include "library/layouts/packing_fraction.h"
#include "library/layouts/placement.h"

namespace cdb::layouts {
namespace {

using Eigen::Vector3d;

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
  DrawnPlacer(const plan::Scene& scene, Bodies& bodies)
      : scene_(scene),
        bodies_(bodies),
        side_(bodies.side()),
        fraction_(bodies),
        grid_(side_, ExtentsOf(bodies)),
        coverage_(bodies, grid_),
        tries_left_(kMinTriesOfAll + kMeanTriesOfAll * bodies.size()) {
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

  /// The open box for the centre of mass that keeps the object between the walls.
  objects::Box DomainOf(std::size_t index) const {
    const objects::Box& bounds = bodies_.bounds(index);
    return {Vector3d::Constant(-side_ / 2) - bounds.lower,
            Vector3d::Constant(side_ / 2) - bounds.upper};
  }

  void PlaceNormal(const GroupRange& range, distributions::Stream& stream) {
    for (std::size_t index = range.first; index < range.end; ++index) {
      const auto draw_along = [&](double, double) { return side_ / 6 * stream.Normal(); };
      if (!PlacePlainly(index, kMaxTriesOfOne, draw_along))
        fraction_.TooFull(index, PackingFraction::kGivenUp);
    }
  }

  void PlaceUniform(const GroupRange& range, distributions::Stream& stream) {
    const auto draw_along = [&](double low, double high) { return stream.Uniform(low, high); };
    std::optional<VoxelSearch> search;
    for (std::size_t index = range.first; index < range.end; ++index) {
      if (!search) {
        if (PlacePlainly(index, misses_before_voxels_, draw_along)) continue;
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
        place[axis] = Coordinate(index, domain.lower[axis], domain.upper[axis], draw_along);
      if (ColliderAt(index, place) == kNobody) {
        Settle(index, place);
        return true;
      }
      CountTry(index);
    }
    return false;
  }

  /// A coordinate strictly between `low` and `high`. The axes are independent, so redrawing one
  /// coordinate gives the same distribution as redrawing the whole position.
  template <typename DrawAlong>
  double Coordinate(std::size_t index, double low, double high, DrawAlong draw_along) {
    for (std::uint64_t tries = 0; tries < kMaxTriesOfOne; ++tries) {
      const double x = draw_along(low, high);
      if (x > low && x < high) return x;
      CountTry(index);
    }
    fraction_.TooFull(index, PackingFraction::kGivenUp);
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
      if (voxels.empty()) fraction_.TooFull(index, PackingFraction::kNoPlaceLeft);
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
      if (!voxels.CanSplit()) fraction_.TooFull(index, PackingFraction::kGivenUp);
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
    if (tries_left_-- == 0) fraction_.TooFull(index, PackingFraction::kGivenUp);
  }

  const plan::Scene& scene_;
  Bodies& bodies_;
  double side_;
  PackingFraction fraction_;
  BoxGrid grid_;
  Coverage coverage_;
  std::unique_ptr<Hints> hints_;  ///< null in a sparse cube
  std::uint64_t tries_left_;
  std::uint64_t misses_before_voxels_ = 0;
};

}  // namespace

void PlaceDrawn(const plan::Scene& scene, Bodies& bodies) { DrawnPlacer(scene, bodies).PlaceAll(); }

}  // namespace cdb::layouts
