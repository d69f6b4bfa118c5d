#include "library/layouts/placement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "dsl/check.h"
#include "library/distributions/draw.h"
#include "library/layouts/free_voxels.h"
#include "library/layouts/grid.h"
#include "library/objects/overlap.h"

namespace cdb::library {
namespace {

using Eigen::Vector3d;

constexpr char kAxes[] = "xyz";
constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();
constexpr std::uint32_t kNobody = std::numeric_limits<std::uint32_t>::max();

/// Room for rounding where distances alone decide.
constexpr double kRounding = 1e-9;

/// Voxels for each object of the scene: of a new lattice, and of a list that is still halved.
constexpr double kVoxelsPerObject = 32;
constexpr double kMinVoxels = 1 << 16;
constexpr std::size_t kSplitVoxelsPerObject = 8;
constexpr std::size_t kMinSplitVoxels = 1 << 19;

/// Below this, few draws miss.
constexpr double kMinFillForHints = 0.05;
/// Times the inner radius.
constexpr double kHintReach = 1.0;

bool Meet(const Box& a, const Box& b) {
  return (a.lower.array() <= b.upper.array()).all() && (a.upper.array() >= b.lower.array()).all();
}

Box Shifted(const Box& box, const Vector3d& by) { return {by + box.lower, by + box.upper}; }

/// Balls about the centre of mass, inside and around a solid: most pairs are decided by them.
struct Core {
  Vector3d position = Vector3d::Zero();
  double inner = 0, outer = 0;  ///< radii, m
};

Core CoreOf(const Solid& solid) {
  const Vector3d half = solid.HalfExtents();
  const double outer =
      solid.shape == Shape::kEllipsoid ? half.maxCoeff() : half.norm() + solid.BoxCentre();
  return {Vector3d::Zero(), solid.InnerRadius(), outer};
}

/// What the voxels of a list are free for: a solid that every object to come has inside it, at its
/// centre of mass. What is not free for the probe is free for none of them.
struct Probe {
  Solid solid;
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Box bounds;
  Core core;
};

/// Who stood in the way where: remembered for each cell of a fine grid, so that most draws that
/// miss meet one object alone. It may forget and err; it only says whom to ask first.
class Hints {
 public:
  Hints(double side, std::size_t objects) : half_side_(side / 2) {
    const double along =
        std::clamp(std::floor(2 * std::cbrt(static_cast<double>(objects))), 1.0, double{kMaxAlong});
    along_ = static_cast<std::size_t>(along);
    per_metre_ = along / side;
    ids_.assign(along_ * along_ * along_, kNobody);
  }

  std::uint32_t At(const Vector3d& place) const {
    return ids_[(Cell(place.x()) * along_ + Cell(place.y())) * along_ + Cell(place.z())];
  }

  void Set(const Box& box, std::uint32_t id) {
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

struct VoxelSearch {
  Probe probe;
  bool exact;  ///< the probe is each of the objects to come
  FreeVoxels voxels;
  std::uint64_t misses = 0;  ///< of all objects since the voxels were halved
};

class Placer {
 public:
  Placer(const compiler::Scene& scene, InitialState& state)
      : scene_(scene),
        state_(state),
        side_(scene.world.Real("world.side")),
        bounds_(BoundsOf(state)),
        grid_(side_, ExtentsOf(bounds_)),
        tries_left_(kMinTriesOfAll + kMeanTriesOfAll * state.objects.size()) {
    double fill = 0;
    cores_.reserve(state.objects.size());
    for (std::size_t i = 0; i < state.objects.size(); ++i) {
      const Solid& solid = state.objects[i].solid;
      cores_.push_back(CoreOf(solid));
      boxes_volume_ += (bounds_[i].upper - bounds_[i].lower).prod();
      fill += solid.IsBall() ? solid.Volume() : (bounds_[i].upper - bounds_[i].lower).prod();
    }
    if (fill > kMinFillForHints * Cube()) hints_.emplace(side_, state.objects.size());
    misses_before_voxels_ = fill <= kMaxPlainFill * Cube() ? kMaxTriesOfOne : kMissesBeforeVoxels;
  }

  void PlaceAll() {
    RefuseWhatCannotFit();
    std::size_t index = 0;
    for (const compiler::Group& group : scene_.groups) {
      const std::uint64_t quantity = group.settings.Count("quantity");
      if (quantity == 0) continue;
      const std::string_view layout = group.settings.WordOr("location");
      CDB_CHECK(layout == "uniform" || layout == "normal");
      Stream stream = NamedStream(scene_, group.name, "location");
      if (layout == "normal") {
        PlaceNormal(index, quantity, stream);
      } else {
        PlaceUniform(index, quantity, stream);
      }
      index += quantity;
    }
  }

 private:
  static std::vector<Box> BoundsOf(const InitialState& state) {
    std::vector<Box> bounds;
    bounds.reserve(state.objects.size());
    for (const ObjectState& object : state.objects)
      bounds.push_back(Bounds(object.solid, object.pose.orientation));
    return bounds;
  }

  static std::vector<double> ExtentsOf(const std::vector<Box>& bounds) {
    std::vector<double> extents;
    extents.reserve(bounds.size());
    for (const Box& box : bounds) extents.push_back((box.upper - box.lower).maxCoeff());
    return extents;
  }

  double Cube() const { return side_ * side_ * side_; }

  /// Where the centre of mass may be for the box to lie between the walls: strictly inside this.
  Box Domain(const Box& bounds) const {
    return {Vector3d::Constant(-side_ / 2) - bounds.lower,
            Vector3d::Constant(side_ / 2) - bounds.upper};
  }

  Box DomainOf(std::size_t index) const {
    const Box domain = Domain(bounds_[index]);
    for (int axis = 0; axis < 3; ++axis)
      if (!(domain.lower[axis] < domain.upper[axis])) TooLarge(index, axis);
    return domain;
  }

  void PlaceNormal(std::size_t first, std::uint64_t quantity, Stream& stream) {
    for (std::size_t index = first; index < first + quantity; ++index) {
      const auto draw_along = [&](double, double) { return side_ / 6 * stream.Normal(); };
      if (!PlacePlainly(index, kMaxTriesOfOne, draw_along)) TooFull(index, kGivenUp);
    }
  }

  void PlaceUniform(std::size_t first, std::uint64_t quantity, Stream& stream) {
    const auto draw_along = [&](double low, double high) { return stream.Uniform(low, high); };
    std::optional<VoxelSearch> search;
    for (std::size_t index = first; index < first + quantity; ++index) {
      if (!search) {
        if (PlacePlainly(index, misses_before_voxels_, draw_along)) continue;
        search.emplace(SearchFor(index, first + quantity));
      }
      const std::uint64_t max_misses = search->exact ? kNoLimit : kMissesBeforeVoxels;
      if (PlaceInVoxels(index, *search, max_misses, stream)) continue;
      // The voxels are free for something smaller: find this object's own.
      VoxelSearch own = SearchFor(index, index + 1);
      PlaceInVoxels(index, own, kNoLimit, stream);
    }
  }

  template <typename DrawAlong>
  bool PlacePlainly(std::size_t index, std::uint64_t max_misses, DrawAlong draw_along) {
    const Box domain = DomainOf(index);
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

  /// A coordinate strictly between `low` and `high`. The axes are independent, so drawing one again
  /// by itself gives the same distribution as drawing the whole place again.
  template <typename DrawAlong>
  double Coordinate(std::size_t index, double low, double high, DrawAlong draw_along) {
    for (std::uint64_t tries = 0; tries < kMaxTriesOfOne; ++tries) {
      const double x = draw_along(low, high);
      if (x > low && x < high) return x;
      CountTry(index);
    }
    TooFull(index, kGivenUp);
  }

  /// The voxels that are free for the objects from `first` to before `end`: for the object itself
  /// where all are alike, else for the largest ball that each of them holds.
  VoxelSearch SearchFor(std::size_t first, std::size_t end) {
    const ObjectState& object = state_.objects[first];
    bool alike = true;
    double radius = object.solid.InnerRadius();
    Box domain = DomainOf(first);
    for (std::size_t i = first + 1; i < end; ++i) {
      const ObjectState& other = state_.objects[i];
      alike = alike && other.solid.shape == object.solid.shape &&
              other.solid.sides == object.solid.sides &&
              (object.solid.IsBall() ||
               other.pose.orientation.coeffs() == object.pose.orientation.coeffs());
      radius = std::min(radius, other.solid.InnerRadius());
      const Box other_domain = DomainOf(i);
      domain.lower = domain.lower.cwiseMin(other_domain.lower);
      domain.upper = domain.upper.cwiseMax(other_domain.upper);
    }
    Probe probe;
    if (alike) {
      probe.solid = object.solid;
      probe.orientation = object.pose.orientation;
    } else {
      probe.solid = {Shape::kEllipsoid, Vector3d::Constant(2 * radius)};
    }
    probe.bounds = Bounds(probe.solid, probe.orientation);
    probe.core = CoreOf(probe.solid);
    const double most = kMinVoxels + kVoxelsPerObject * static_cast<double>(state_.objects.size());
    const auto covered = [&](const Box& voxel) { return IsCovered(probe, voxel, first); };
    FreeVoxels voxels(domain.lower, domain.upper, radius, most, covered);
    return {probe, alike, std::move(voxels)};
  }

  /// False where `max_misses` draws in a row were not free. Throws SceneError where no voxel is
  /// left.
  bool PlaceInVoxels(std::size_t index, VoxelSearch& search, std::uint64_t max_misses,
                     Stream& stream) {
    const Box domain = DomainOf(index);
    for (std::uint64_t misses = 0; misses < max_misses; ++misses) {
      FreeVoxels& voxels = search.voxels;
      if (voxels.empty()) TooFull(index, kNoPlaceLeft);
      const double count = static_cast<double>(voxels.size());
      // The product may round up to the count.
      const std::size_t drawn =
          std::min(static_cast<std::size_t>(count * stream.Uniform()), voxels.size() - 1);
      const Box voxel = voxels.BoxOf(drawn);
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
      if (fits && Covers(collider, search.probe, voxel)) voxels.Remove(drawn);
      // Two draws for each voxel have found nearly all that one object covers.
      if (++search.misses < 2 * voxels.size()) continue;
      if (voxels.size() > kMinSplitVoxels + kSplitVoxelsPerObject * state_.objects.size()) continue;
      if (!voxels.CanSplit()) TooFull(index, kGivenUp);
      voxels.Split([&](const Box& part) { return IsCovered(search.probe, part, index); });
      search.misses = 0;
    }
    return false;
  }

  /// Any object that the object would touch at `place`.
  std::uint32_t ColliderAt(std::size_t index, const Vector3d& place) {
    std::uint32_t collider = hints_ ? hints_->At(place) : kNobody;
    const Box box = Shifted(bounds_[index], place);
    if (collider != kNobody && Touches(index, place, box, collider)) return collider;
    collider = kNobody;
    grid_.AnyOf(box, [&](std::uint32_t other) {
      if (!Touches(index, place, box, other)) return false;
      collider = other;
      return true;
    });
    if (hints_ && collider != kNobody) hints_->Set({place, place}, collider);
    return collider;
  }

  bool Touches(std::size_t index, const Vector3d& place, const Box& box,
               std::uint32_t other) const {
    const Core& core = cores_[index];
    const Core& theirs = cores_[other];
    const double distance = (theirs.position - place).squaredNorm();
    const double inner = core.inner + theirs.inner;
    if (distance < inner * inner * (1 - kRounding)) return true;
    const double outer = core.outer + theirs.outer;
    if (distance > outer * outer * (1 + kRounding)) return false;
    const ObjectState &object = state_.objects[index], &neighbour = state_.objects[other];
    return Meet(box, Shifted(bounds_[other], neighbour.pose.position)) &&
           Overlap(object.solid, {place, object.pose.orientation}, neighbour.solid, neighbour.pose);
  }

  /// Whether the probe touches object `other` wherever in the voxel it is. The places where two
  /// convex solids touch are convex, so the corners decide.
  bool Covers(std::uint32_t other, const Probe& probe, const Box& voxel) const {
    const Core& theirs = cores_[other];
    const Vector3d to_lower = (theirs.position - voxel.lower).cwiseAbs();
    const Vector3d to_upper = (theirs.position - voxel.upper).cwiseAbs();
    const double farthest = to_lower.cwiseMax(to_upper).squaredNorm();
    const double inner = probe.core.inner + theirs.inner;
    if (farthest < inner * inner * (1 - kRounding)) return true;
    const double outer = probe.core.outer + theirs.outer;
    if (farthest > outer * outer * (1 + kRounding)) return false;
    const ObjectState& neighbour = state_.objects[other];
    for (int corner = 0; corner < 8; ++corner) {
      Vector3d place;
      for (int axis = 0; axis < 3; ++axis)
        place[axis] = (corner >> axis & 1) != 0 ? voxel.upper[axis] : voxel.lower[axis];
      if (!Overlap(probe.solid, {place, probe.orientation}, neighbour.solid, neighbour.pose))
        return false;
    }
    return true;
  }

  /// `index` is the object for which the voxel is looked at.
  bool IsCovered(const Probe& probe, const Box& voxel, std::size_t index) {
    CountTry(index);
    // Who covers the voxel covers its centre.
    const Box box = Shifted(probe.bounds, (voxel.lower + voxel.upper) / 2);
    if (grid_.AnyOf(box, [&](std::uint32_t other) { return Covers(other, probe, voxel); }))
      return true;
    return IsUnturnedCuboid(probe.solid, probe.orientation) && IsCoveredBySlabs(probe, voxel);
  }

  static bool IsUnturnedCuboid(const Solid& solid, const Eigen::Quaterniond& orientation) {
    return solid.shape == Shape::kCuboid &&
           orientation.coeffs() == Eigen::Quaterniond::Identity().coeffs();
  }

  /// Whether unturned cuboids cut the voxel away slice by slice. Two of them with hardly less than
  /// the probe's room between their faces cover many voxels together and none alone, until the
  /// voxels are as thin as what lacks.
  bool IsCoveredBySlabs(const Probe& probe, const Box& voxel) const {
    Box left = voxel;
    const Box reach{voxel.lower + probe.bounds.lower, voxel.upper + probe.bounds.upper};
    const auto cut = [&](std::uint32_t other) {
      const ObjectState& neighbour = state_.objects[other];
      if (!IsUnturnedCuboid(neighbour.solid, neighbour.pose.orientation)) return false;
      const Box theirs = Shifted(bounds_[other], neighbour.pose.position);
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
    // A cut may let a cuboid span what is left that did not before.
    constexpr int kRounds = 3;
    for (int round = 0; round < kRounds; ++round)
      if (grid_.AnyOf(reach, cut)) return true;
    return false;
  }

  void Settle(std::size_t index, const Vector3d& place) {
    state_.objects[index].pose.position = place;
    cores_[index].position = place;
    const auto id = static_cast<std::uint32_t>(index);
    grid_.Add(id, Shifted(bounds_[index], place));
    if (!hints_) return;
    // Whoever comes is likely to be as large, and to touch it from here.
    const Vector3d reach = Vector3d::Constant(kHintReach * cores_[index].inner);
    hints_->Set({place - reach, place + reach}, id);
  }

  void CountTry(std::size_t index) {
    if (tries_left_-- == 0) TooFull(index, kGivenUp);
  }

  void RefuseWhatCannotFit() const {
    for (std::size_t index = 0; index < state_.objects.size(); ++index) DomainOf(index);
    if (state_.fill_fraction > 1) {
      throw SceneError(
          fmt::format("all objects together fill {:.4g} % of the cube: more than there is, so none "
                      "was placed; {}",
                      100 * state_.fill_fraction, Advice()));
    }
    std::size_t first = 0;
    for (const compiler::Group& group : scene_.groups) {
      const std::uint64_t quantity = group.settings.Count("quantity");
      RefuseGroup(group.name, first, quantity);
      first += quantity;
    }
  }

  void RefuseGroup(const std::string& name, std::size_t first, std::uint64_t quantity) const {
    if (quantity < kManyObjects) return;
    const Solid& solid = state_.objects[first].solid;
    for (std::size_t i = first; i < first + quantity; ++i) {
      const Solid& other = state_.objects[i].solid;
      if (other.shape != solid.shape || other.sides != solid.sides) return;
      if ((bounds_[i].upper - bounds_[i].lower).maxCoeff() > kShortOfSide * side_) return;
    }
    const double most = solid.IsBall() ? kMaxFillOfBalls : kMaxFillOfOthers;
    const double fill = static_cast<double>(quantity) * solid.Volume() / Cube();
    if (fill <= most) return;
    throw SceneError(fmt::format(
        "the {} objects of group `{}` fill {:.3g} % of the cube: equal objects at places drawn by "
        "chance leave no free place before {:.3g} %, so none was placed; {}",
        quantity, name, 100 * fill, 100 * most, Advice()));
  }

  std::string Name(std::size_t index) const {
    const std::string& group = scene_.groups[state_.objects[index].group].name;
    return fmt::format("object {} of {} (group `{}`)", index + 1, state_.objects.size(), group);
  }

  [[noreturn]] void TooLarge(std::size_t index, int axis) const {
    const Box& box = bounds_[index];
    throw SceneError(
        fmt::format("{} is {:.6g} m long along {} and does not fit between walls {:.6g} m apart; "
                    "make world.side larger or the size smaller",
                    Name(index), box.upper[axis] - box.lower[axis], kAxes[axis], side_));
  }

  std::string Advice() const {
    // Boxes filling a tenth of the cube leave room for chance, whatever the shapes.
    return fmt::format(
        "make world.side larger ({:.4g} m would do) or the size or the quantity smaller",
        std::max(side_ * 1.1, std::cbrt(boxes_volume_ * 10)));
  }

  static constexpr std::string_view kGivenUp = "every place drawn was taken";
  static constexpr std::string_view kNoPlaceLeft = "no free place was left";

  [[noreturn]] void TooFull(std::size_t index, std::string_view when) const {
    double placed = 0;
    for (std::size_t i = 0; i < index; ++i) placed += state_.objects[i].solid.Volume();
    throw SceneError(fmt::format(
        "no free place was found for {}: all objects together fill {:.3g} % of the cube ({:.3g} % "
        "with the boxes around them), {:.3g} % was filled when {}; {}",
        Name(index), 100 * state_.fill_fraction, 100 * boxes_volume_ / Cube(),
        100 * placed / Cube(), when, Advice()));
  }

  const compiler::Scene& scene_;
  InitialState& state_;
  double side_;
  double boxes_volume_ = 0;  ///< of all objects, m^3
  std::vector<Box> bounds_;  ///< around each object, its centre of mass at the origin
  std::vector<Core> cores_;  ///< by object
  BoxGrid grid_;
  std::optional<Hints> hints_;  ///< in a cube that is not sparse
  std::uint64_t tries_left_;
  std::uint64_t misses_before_voxels_ = 0;
};

}  // namespace

void Place(const compiler::Scene& scene, InitialState& state) { Placer(scene, state).PlaceAll(); }

}  // namespace cdb::library
