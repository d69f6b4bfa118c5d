#include "library/layouts/exact_layouts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string_view>

#include "compiler/schema/parametrised_words.h"
#include "compiler/yaml/plan_yaml.h"
#include "dsl/text/check.h"
#include "library/distributions/draw.h"
#include "library/layouts/initial_state.h"
#include "library/layouts/region.h"
#include "library/objects/distance.h"

namespace cdb::layouts {
namespace {

using Eigen::Vector3d;

const schema::Call& LayoutOf(const plan::Group& group) {
  const schema::Call* layout = schema::AsCall(group.settings.Get("location"));
  CDB_CHECK(layout != nullptr);
  return *layout;
}

/// Empty if the argument is a word: `fit`, `all`.
template <typename T>
std::optional<T> Argument(const schema::Call& layout, std::string_view name) {
  const schema::Value& value = schema::ArgumentOf(layout, name);
  if (std::holds_alternative<schema::Word>(value)) return std::nullopt;
  return std::get<T>(value);
}

/// Empty if the argument is a word.
std::optional<double> RealArgument(const schema::Call& layout, std::string_view name) {
  const auto number = Argument<schema::Number>(layout, name);
  return number ? std::optional(number->AsReal()) : std::nullopt;
}

/// The smallest number whose `power` is at least n.
std::size_t RootUp(std::size_t n, auto power) {
  std::size_t root = 0;
  while (power(root) < n) ++root;
  return root;
}

std::size_t Square(std::size_t k) { return k * k; }
std::size_t Cube(std::size_t k) { return k * k * k; }
/// k^2 + (k - 1)^2 + ... + 1.
std::size_t SquarePyramidal(std::size_t k) { return k * (k + 1) * (2 * k + 1) / 6; }

/// The coordinate of the `index`th of `count` points at intervals of `spacing`, centred on 0.
double Along(std::size_t index, std::size_t count, double spacing) {
  return (static_cast<double>(index) - static_cast<double>(count - 1) / 2) * spacing;
}

/// The smallest r >= 0 at which boxes with centres r * chord apart and a sum of half extents of
/// `halves` have a gap of `gap` between them. The chord is level and not 0.
double LeastRadius(const Vector3d& chord, const Vector3d& halves, double gap) {
  // Along one axis the gap is r * along - half, if that is positive.
  struct Axis {
    double along, half;
    double Opens() const { return along > 0 ? half / along : HUGE_VAL; }
  };
  Axis first{std::abs(chord.x()), halves.x()}, second{std::abs(chord.z()), halves.z()};
  if (second.Opens() < first.Opens()) std::swap(first, second);
  const double alone = (first.half + gap) / first.along;
  if (alone <= second.Opens()) return alone;
  // (r along1 - half1)^2 + (r along2 - half2)^2 = gap^2, the larger root.
  const double a = first.along * first.along + second.along * second.along;
  const double b = first.along * first.half + second.along * second.half;
  const double cross = first.along * second.half - second.along * first.half;
  return (b + std::sqrt(std::max(a * gap * gap - cross * cross, 0.0))) / a;
}

class ExactPlacer {
 public:
  ExactPlacer(const plan::Scene& scene, const GroupRange& range, Bodies& bodies)
      : scene_(scene),
        range_(range),
        layout_(LayoutOf(*range.group)),
        bodies_(bodies),
        region_(RegionOf(bodies, range)),
        floor_(region_.box.lower.y() - region_.Centre().y()) {
    for (std::size_t i = 0; i < range.size(); ++i) largest_ = largest_.cwiseMax(Extents(i));
  }

  void Grid() {
    const std::size_t count = RootUp(range_.size(), Cube);
    const std::optional<double> spacing = Length("spacing");
    const Vector3d fit = region_.Extents() / static_cast<double>(count);
    for (std::size_t i = 0; i < range_.size(); ++i) {
      const auto along = [&](std::size_t cell, int axis) {
        return Along(cell % count, count, spacing.value_or(fit[axis]));
      };
      PutBoxAt(i, {along(i, 0), along(i / Square(count), 1), along(i / count, 2)});
    }
    Stand();
  }

  void Stack() {
    const std::size_t n = range_.size();
    const std::size_t height = Argument<schema::Number>(layout_, "height").value_or(n).AsCount();
    const std::size_t columns = (n + height - 1) / height;
    const std::size_t edge = RootUp(columns, Square);
    const double spacing = Length("spacing").value_or(1.5 * std::max(largest_.x(), largest_.z()));
    const std::optional<double> gap = Length("gap");
    double top = 0;  // of the object below
    for (std::size_t i = 0; i < n; ++i) {
      const bool is_lowest = i % height == 0;
      const double tall = Extents(i).y();
      const double larger = is_lowest ? tall : std::max(tall, Extents(i - 1).y());
      const double bottom = (is_lowest ? floor_ : top) + gap.value_or(kStandingGap * larger);
      const std::size_t column = i / height;
      PutBoxAt(i, {Along(column % edge, edge, spacing), bottom + tall / 2,
                   Along(column / edge, edge, spacing)});
      top = bottom + tall;
    }
  }

  void Pyramid() {
    const std::size_t base = RootUp(range_.size(), SquarePyramidal);
    const double gap = Length("gap").value_or(kStandingGap * largest_.maxCoeff());
    const Vector3d cell = largest_ + Vector3d::Constant(gap);
    std::size_t layer = 0, at = 0;  // in its layer
    for (std::size_t i = 0; i < range_.size(); ++i, ++at) {
      if (at == Square(base - layer)) {
        ++layer;
        at = 0;
      }
      const std::size_t edge = base - layer;
      const double bottom = floor_ + gap + static_cast<double>(layer) * cell.y();
      PutBoxAt(i, {Along(at % edge, edge, cell.x()), bottom + Extents(i).y() / 2,
                   Along(at / edge, edge, cell.z())});
    }
  }

  void Ring() {
    const std::size_t n = range_.size();
    const auto on_circle = [&](std::size_t i) -> Vector3d {
      // The last bit depends on std::sin and std::cos.
      const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
      return {std::cos(angle), 0, std::sin(angle)};
    };
    double fit = 0;
    for (std::size_t i = 0; n > 1 && i < n; ++i) {
      const std::size_t next = (i + 1) % n;
      fit = std::max(fit, LeastRadius(on_circle(next) - on_circle(i),
                                      (Extents(i) + Extents(next)) / 2, 0.1 * largest_.maxCoeff()));
    }
    const double radius = Length("radius").value_or(fit);
    for (std::size_t i = 0; i < n; ++i) PutBoxAt(i, radius * on_circle(i));
    Stand();
  }

  void Line() {
    const auto given = Argument<Vector3d>(layout_, "along");
    const Vector3d along = given ? given->stableNormalized() : Vector3d(0, -1, 0);
    const double gap = Length("gap").value_or(0.1 * largest_.maxCoeff());
    const auto reach = [&](std::size_t i, const Vector3d& direction) {
      const ObjectState& object = bodies_.object(range_.first + i);
      const Vector3d local = object.pose.orientation.conjugate() * direction;
      return object.solid.Support(local).dot(local);
    };
    std::vector<double> places;
    double end = 0;
    for (std::size_t i = 0; i < range_.size(); ++i) {
      if (i > 0) end += gap;
      places.push_back(end + reach(i, -along));
      end = places.back() + reach(i, along);
    }
    for (std::size_t i = 0; i < range_.size(); ++i) Put(i, (places[i] - end / 2) * along);
    Stand();
  }

  void At() {
    RefuseRegion();
    if (ListsPoints(layout_)) {
      const std::size_t count = layout_.arguments.size();
      Require(count, fmt::format("places {} object{}", count, count == 1 ? "" : "s"),
              "list a point for each object");
      for (std::size_t i = 0; i < count; ++i)
        PutOriginAt(range_.first + i, *AsVector(layout_.arguments[i]));
      return;
    }
    Require(1, "places one object", "make the quantity 1, or list a point for each object");
    const auto coordinate = [&](std::string_view name) { return *Length(name); };
    PutOriginAt(range_.first, {coordinate("x"), coordinate("y"), coordinate("z")});
  }

  /// The origin of a mesh may be another point than its centre of mass.
  void PutOriginAt(std::size_t index, const Vector3d& point) {
    const ObjectState& object = bodies_.object(index);
    const objects::Pose turned = objects::OriginOf(object.solid, object.pose);
    bodies_.MoveTo(index, objects::BodyOf(object.solid, {point, turned.orientation}).position);
  }

  void RelativeTo() {
    RefuseRegion();
    const std::string& name = std::get<schema::Word>(schema::ArgumentOf(layout_, "group")).text;
    const GroupRange& others = GroupBefore(bodies_, range_, name, "location");
    if (others.size() != 1)
      Require(others.size(),
              fmt::format("places one at each of the {} of `{}`", others.size(), name),
              fmt::format("remove the quantity: it is that of `{}`", name));
    const auto& offset = std::get<Vector3d>(schema::ArgumentOf(layout_, "offset"));
    const plan::Joint* joint = JointTo(name);
    for (std::size_t i = 0; i < range_.size(); ++i) {
      const ObjectState& other = bodies_.object(others.first + (others.size() == 1 ? 0 : i));
      const ObjectState& object = bodies_.object(range_.first + i);
      const objects::Pose frame = objects::OriginOf(other.solid, other.pose);
      const Eigen::Quaterniond turn = objects::OriginOf(object.solid, object.pose).orientation;
      objects::Pose origin{frame.position + frame.orientation * offset, frame.orientation * turn};
      if (joint != nullptr) MoveAbout(*joint, frame, origin);
      bodies_.MoveTo(range_.first + i, objects::BodyOf(object.solid, origin));
    }
  }

  /// The joint of the group to `parent` that does not start at 0; null if there is none.
  const plan::Joint* JointTo(std::string_view parent) const {
    for (const plan::Joint& joint : scene_.joints)
      if (joint.settings.WordOr("joints.child") == range_.group->name &&
          joint.settings.WordOr("joints.parent") == parent &&
          joint.settings.Real("joints.start") != 0)
        return &joint;
    return nullptr;
  }

  /// Moves the child of the joint to its position; `parent` is the frame of the joint's parent.
  static void MoveAbout(const plan::Joint& joint, const objects::Pose& parent,
                        objects::Pose& child) {
    const double position = joint.settings.Real("joints.start");
    const Vector3d axis =
        parent.orientation * joint.settings.Vector("joints.axis").stableNormalized();
    if (joint.settings.WordOr("joints.type") == "slider") {
      child.position += position * axis;
      return;
    }
    const Vector3d pivot =
        parent.position + parent.orientation * joint.settings.Vector("joints.at");
    const Eigen::Quaterniond turn = TurnAbout(position * axis);
    child.position = pivot + turn * (child.position - pivot);
    child.orientation = turn * child.orientation;
  }

  /// DrawObjects has already set their positions.
  void Poses() { RefuseRegion(); }

  void Pair() {
    Require(2, "takes two objects", "make the quantity 2, and write a group for each pair");
    const ObjectState &a = bodies_.object(range_.first), &b = bodies_.object(range_.first + 1);
    const double distance = *Length("distance");
    distributions::Stream stream =
        distributions::NamedStream(scene_, range_.group->name, "location");
    for (int tries = 0; tries < kMaxDirections; ++tries) {
      const double x = stream.Normal();
      const double y = stream.Normal();
      const Vector3d direction = Vector3d(x, y, stream.Normal()).normalized();
      const auto apart = objects::Approach(a.solid, a.pose, b.solid, b.pose, direction, distance);
      if (!apart) continue;
      Put(0, -*apart / 2 * direction);
      Put(1, *apart / 2 * direction);
      Stand();
      return;
    }
    throw library::SceneError(fmt::format("group `{}`: {} directions were drawn for its pair, but "
                                          "the objects come within {:.6g} m of each other in none",
                                          range_.group->name, kMaxDirections, distance),
                              "make the distance larger", range_.group->name);
  }

  void Pile() {
    RefuseRegion();
    const std::vector<Vector3d> places =
        PlacesAbovePile(*range_.group, bodies_.side(), bodies_.ObjectsOf(range_));
    for (std::size_t i = 0; i < range_.size(); ++i) bodies_.MoveTo(range_.first + i, places[i]);
  }

 private:
  static constexpr int kMaxDirections = 1000;

  /// Moves the group up or down, so that its lowest object stands on the floor of the region.
  void Stand() {
    if (!region_.stands) return;
    double above = HUGE_VAL;
    for (std::size_t i = 0; i < range_.size(); ++i)
      above = std::min(above, bodies_.BoxOf(range_.first + i).lower.y() -
                                  kStandingGap * Extents(i).y() - region_.box.lower.y());
    for (std::size_t i = range_.first; i < range_.end; ++i)
      bodies_.MoveTo(i, bodies_.object(i).pose.position - above * Vector3d::UnitY());
  }

  void RefuseRegion() const {
    if (region_.IsDefault()) return;
    throw library::SceneError(
        fmt::format("`{}` does not place the objects of group `{}` in a region", layout_.name,
                    range_.group->name),
        "remove the region, or write another location", range_.group->name, "region");
  }

  /// Empty for `fit`.
  std::optional<double> Length(std::string_view name) const { return RealArgument(layout_, name); }

  Vector3d Extents(std::size_t i) const { return bodies_.Extents(range_.first + i); }

  /// Of the centre of mass, from the centre of the region; for stacks and pyramids from its axis.
  void Put(std::size_t i, const Vector3d& place) {
    bodies_.MoveTo(range_.first + i, region_.is_cube ? place : region_.Centre() + place);
  }

  void PutBoxAt(std::size_t i, const Vector3d& centre) {
    const objects::Box& bounds = bodies_.bounds(range_.first + i);
    Put(i, centre - (bounds.lower + bounds.upper) / 2);
  }

  void Require(std::size_t quantity, std::string_view otherwise, const std::string& remedy) const {
    if (range_.size() == quantity) return;
    throw library::SceneError(
        fmt::format("group `{}` has {} objects, but `{}` {}", range_.group->name, range_.size(),
                    layout_.name, otherwise),
        remedy, range_.group->name);
  }

  const plan::Scene& scene_;
  const GroupRange& range_;
  const schema::Call& layout_;
  Bodies& bodies_;
  Region region_;
  double floor_;                         ///< y from the centre of the region, m
  Vector3d largest_ = Vector3d::Zero();  ///< extents along each axis
};

struct LayoutRow {
  std::string_view name;
  void (ExactPlacer::*place)();
  LayoutAdvice advice;
};

constexpr LayoutRow kLayouts[] = {
    {"grid",
     &ExactPlacer::Grid,
     {"make spacing larger (fit grows with world.side) or the size smaller",
      "make spacing or the size smaller or world.side larger"}},
    {"stack",
     &ExactPlacer::Stack,
     {"make gap or spacing larger",
      "make height, gap, spacing or the size smaller or world.side larger"}},
    {"pyramid",
     &ExactPlacer::Pyramid,
     {"make gap larger", "make gap, the size or the quantity smaller or world.side larger"}},
    {"ring",
     &ExactPlacer::Ring,
     {"make radius larger", "make radius or the size smaller or world.side larger"}},
    {"line",
     &ExactPlacer::Line,
     {"make gap larger, or write overlap on",
      "make gap, the size or the quantity smaller or world.side larger"}},
    {"at", &ExactPlacer::At, {"move it", "move it inwards or make world.side larger"}},
    {"pair",
     &ExactPlacer::Pair,
     {"make distance larger", "make distance or the size smaller or world.side larger"}},
    {"relative_to",
     &ExactPlacer::RelativeTo,
     {"move it, or write overlap on", "move it inwards or make world.side larger"}},
    {"poses",
     &ExactPlacer::Poses,
     {"change the file, or write overlap on",
      "change the file, or make world.side larger; overlap on allows it while the centre of mass "
      "is "
      "inside"}},
    {"path",
     &ExactPlacer::Poses,
     {"change the file, or write overlap on", "change the file, or make world.side larger"}},
    {"pile",
     &ExactPlacer::Pile,
     {"make the size smaller", "make width or the size smaller or world.side larger"}},
};

const LayoutRow& RowOf(const plan::Group& group) {
  const auto* row = std::ranges::find(kLayouts, LayoutOf(group).name, &LayoutRow::name);
  CDB_CHECK(row != std::end(kLayouts));
  return *row;
}

}  // namespace

bool HasExactLayout(const plan::Group& group) {
  return schema::AsCall(group.settings.Get("location")) != nullptr;
}

bool IsPile(const plan::Group& group) { return yaml::HasPile(group); }

void PlaceExactly(const plan::Scene& scene, const GroupRange& range, Bodies& bodies) {
  if (range.size() == 0) return;
  ExactPlacer placer(scene, range, bodies);
  (placer.*RowOf(*range.group).place)();
}

std::vector<Vector3d> PlacesAbovePile(const plan::Group& group, double side,
                                      std::span<const ObjectState> objects) {
  double radius = 0;
  for (const ObjectState& object : objects) radius = std::max(radius, object.solid.OuterRadius());
  constexpr double kLoose = 1.05;
  const double cell = 2 * kLoose * radius;
  const std::size_t n = objects.size();
  std::size_t edge = RootUp(n, Cube);
  if (const auto width = RealArgument(LayoutOf(group), "width")) {
    const double cells = std::floor(*width / cell);
    if (cells < 1) {
      throw library::SceneError(
          fmt::format(
              "the pile of group `{}` is {:.6g} m wide, and its largest object needs {:.6g} "
              "m to turn in",
              group.name, *width, cell),
          "make width larger or the size smaller", group.name);
    }
    // More than n along an edge are never used, and might not fit into an integer.
    edge = static_cast<std::size_t>(std::min(cells, static_cast<double>(n)));
  }
  if (edge == 0) return {};
  const double layers = std::ceil(static_cast<double>(n) / static_cast<double>(Square(edge)));
  if (layers * cell > side) {
    throw library::SceneError(
        fmt::format("the {} objects of group `{}` are dropped from {} layers, {:.6g} m high "
                    "together, and the cube is {:.6g} m high",
                    n, group.name, layers, layers * cell, side),
        "make width or world.side larger, or the size or the quantity smaller", group.name);
  }
  std::vector<Vector3d> places;
  places.reserve(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double layer = static_cast<double>(i / Square(edge));
    places.emplace_back(Along(i % edge, edge, cell), (layer + 0.5) * cell - side / 2,
                        Along(i / edge % edge, edge, cell));
  }
  return places;
}

const LayoutAdvice& AdviceOf(const plan::Group& group) {
  static constexpr LayoutAdvice kDrawn = {"make world.side larger or the size smaller",
                                          "make world.side larger or the size smaller"};
  return HasExactLayout(group) ? RowOf(group).advice : kDrawn;
}

}  // namespace cdb::layouts
