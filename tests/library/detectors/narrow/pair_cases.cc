#include "tests/library/detectors/narrow/pair_cases.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

#include "library/exact/signed_distance.h"
#include "library/meshes/convex_hull.h"
#include "library/meshes/mass_properties.h"
#include "tests/library/objects/random_solids.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using objects::Shape;
using objects::Solid;

Vec3 FromEigen(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Vector3d ToEigen(const Vec3& v) { return {v.x, v.y, v.z}; }

std::shared_ptr<const objects::ConvexDecomposition> FormOf(const std::vector<Vector3d>& points) {
  const meshes::Hull hull = *meshes::TryConvexHull(points);
  const meshes::Mesh mesh = meshes::SurfaceOf(hull);
  meshes::Decomposition pieces;
  pieces.hulls = {hull};
  return std::make_shared<const objects::ConvexDecomposition>(
      objects::MakeDecomposition("hull", mesh, meshes::MassPropertiesOf(mesh), pieces));
}

Solid SolidOf(std::shared_ptr<const objects::ConvexDecomposition> form, const Vector3d& sides) {
  Solid solid{Shape::kCompound, sides};
  solid.compound = std::make_shared<const objects::Compound>(std::move(form), sides);
  return solid;
}

std::vector<Vector3d> OnBall(std::size_t count) {
  std::vector<Vector3d> points;
  for (std::size_t i = 0; i < count; ++i) {  // a spiral
    const double z = 1 - (2 * static_cast<double>(i) + 1) / static_cast<double>(count);
    const double angle = 2.399963229728653 * static_cast<double>(i), r = std::sqrt(1 - z * z);
    points.emplace_back(r * std::cos(angle), z, r * std::sin(angle));
  }
  return points;
}

/// Hulls with 6 to 64 vertices, some with faces of many corners.
std::shared_ptr<const objects::ConvexDecomposition> RandomForm(distributions::Stream& stream) {
  static const auto kForms = [] {
    std::vector<std::shared_ptr<const objects::ConvexDecomposition>> forms;
    for (const std::size_t count : {6, 10, 16, 32, 64}) forms.push_back(FormOf(OnBall(count)));
    for (const int corners : {3, 6, 8, 16}) {
      std::vector<Vector3d> prism;
      for (int i = 0; i < 2 * corners; ++i) {
        const double angle = 2 * M_PI * (i / 2) / corners;
        prism.emplace_back(std::cos(angle), i % 2 == 0 ? -1 : 1, std::sin(angle));
      }
      forms.push_back(FormOf(prism));
    }
    return forms;
  }();
  return kForms[static_cast<std::size_t>(stream.Uniform() * static_cast<double>(kForms.size()))];
}

double SizeOf(const PairCase& pair) {
  const double a = pair.a.sides.maxCoeff();
  return pair.is_plane ? a : std::min(a, pair.b.sides.maxCoeff());
}

Eigen::Quaterniond RandomTurn(distributions::Stream& stream, const Eigen::Quaterniond& beside) {
  const double draw = stream.Uniform();
  if (draw < 0.6) return stream.Turn();
  if (draw < 0.7) return beside;
  const int axis = static_cast<int>(stream.Uniform() * 3);
  const double angle = draw < 0.8   ? M_PI / 2
                       : draw < 0.9 ? M_PI / 4
                                    : stream.LogUniform(1e-9, 1e-2);
  return (beside * Eigen::AngleAxisd(angle, Vector3d::Unit(axis))).normalized();
}

}  // namespace

Solid RandomBody(distributions::Stream& stream, Type type, double size, bool thin) {
  Vector3d sides;
  for (double& side : sides) side = size * stream.Uniform(0.4, 1);
  if (thin) sides[static_cast<int>(stream.Uniform() * 3)] *= 0.01;
  switch (type) {
    case Type::kBall:
      return {Shape::kEllipsoid, Vector3d::Constant(size)};
    case Type::kCapsule: {
      const double width = size * (thin ? 0.02 : stream.Uniform(0.2, 0.9));
      return {Shape::kCapsule, Vector3d(width, size, width)};
    }
    case Type::kTetrahedron:
      return {Shape::kTetrahedron, sides};
    case Type::kHull:
      return SolidOf(RandomForm(stream), sides);
    case Type::kCompound: {
      Solid torus = Torus();
      torus.sides = Vector3d(4, 1, 4) * (size / 4);
      torus.compound =
          std::make_shared<const objects::Compound>(torus.compound->shared_form(), torus.sides);
      return torus;
    }
    case Type::kCylinder:
    case Type::kCone:
      if (stream.Uniform() < 0.5) sides.z() = sides.x();
      return {type == Type::kCone ? Shape::kCone : Shape::kCylinder, sides};
    case Type::kEllipsoid:
      return {Shape::kEllipsoid, sides};
    case Type::kFlatCapsule:
      return {Shape::kCapsule, sides};
    case Type::kBox:
    case Type::kPlane:
      break;
  }
  return {Shape::kCuboid, sides};
}

Solid RoundHull(std::size_t vertices, double size) {
  return SolidOf(FormOf(OnBall(vertices)), Vector3d::Constant(size));
}

ExactContact ExactOf(const PairCase& pair) {
  if (pair.is_plane) {
    const Vector3d normal = pair.pose_b.orientation * Vector3d::UnitY();
    const auto found =
        exact::DistanceOf(pair.a, pair.pose_a, {normal, normal.dot(pair.pose_b.position)});
    return {found.gap, normal, true};
  }
  const auto found = exact::DistanceOf(pair.a, pair.pose_a, pair.b, pair.pose_b);
  return {found.gap, found.normal, found.IsTight(SizeOf(pair))};
}

double GapAlong(const PairCase& pair, const Vector3d& normal) {
  const double low = normal.dot(WorldSupport(pair.a, pair.pose_a, -normal));
  if (pair.is_plane) {
    const Vector3d up = pair.pose_b.orientation * Vector3d::UnitY();
    if (up.cross(normal).norm() > 1e-6) return -std::numeric_limits<double>::infinity();
    return low - normal.dot(pair.pose_b.position);
  }
  return low - normal.dot(WorldSupport(pair.b, pair.pose_b, normal));
}

void MoveToGap(PairCase& pair, double gap) {
  const ExactContact exact = ExactOf(pair);
  pair.pose_b.position += (exact.gap - gap) * exact.normal;
}

PairCase RandomPair(distributions::Stream& stream, Type a, Type b) {
  constexpr double kSizes[] = {0.01, 1, 100};
  const double size = stream.Uniform() < 0.7 ? 1 : kSizes[static_cast<int>(stream.Uniform() * 3)];
  const double other = stream.Uniform() < 0.8 ? size : size * (stream.Uniform() < 0.5 ? 0.01 : 30);
  PairCase pair{.a = RandomBody(stream, a, size, stream.Uniform() < 0.15),
                .b = RandomBody(stream, b, other, stream.Uniform() < 0.15),
                .pose_a = {},
                .pose_b = {},
                .is_plane = b == Type::kPlane};
  const double span = pair.a.sides.norm() + pair.b.sides.norm();
  pair.pose_a.position = RandomDirection(stream) * stream.Uniform(0, 5) * size;
  pair.pose_a.orientation = stream.Uniform() < 0.3 ? Eigen::Quaterniond::Identity() : stream.Turn();
  pair.pose_b.orientation = RandomTurn(stream, pair.pose_a.orientation);
  pair.pose_b.position = pair.pose_a.position;
  const double draw = stream.Uniform();
  if (draw < 0.04) return pair;
  Vector3d way = RandomDirection(stream);
  if (draw < 0.3) way = pair.pose_a.orientation * Vector3d::Unit(static_cast<int>(draw * 100) % 3);
  if (draw < 0.1) {
    pair.pose_b.position += way * stream.Uniform(0, 0.2) * span;
    return pair;
  }
  pair.pose_b.position += way * stream.Uniform(0.5, 1) * span;
  const double least = SizeOf(pair);
  MoveToGap(pair, stream.Uniform() < 0.25 ? stream.LogUniform(1e-6, 0.02) * std::min(1.0, least)
                                          : -stream.LogUniform(1e-5, 0.2) * least);
  return pair;
}

PairScene::PairScene(const std::vector<PairCase>& pairs) {
  for (const PairCase& pair : pairs) {
    const auto id = static_cast<Id>(shapes_.size());
    Add(pair.a, pair.pose_a, false);
    Add(pair.b, pair.pose_b, pair.is_plane);
    pairs_.push_back({id, id + 1});
  }
  filters_.resize(shapes_.size());
}

void PairScene::Add(const Solid& solid, const objects::Pose& pose, bool is_plane) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const Eigen::Matrix3d axes = pose.orientation.toRotationMatrix();
  poses_.push_back({FromEigen(pose.position), FromEigen(axes.col(0)), FromEigen(axes.col(1)),
                    FromEigen(axes.col(2))});
  if (is_plane) {
    shapes_.push_back({.kind = ShapeKind::kPlane,
                       .half = {kInfinite, kInfinite, kInfinite},
                       .centre = {},
                       .normal = {0, 1, 0},
                       .hulls = {}});
    boxes_.push_back({{-kInfinite, -kInfinite, -kInfinite}, {kInfinite, kInfinite, kInfinite}});
    return;
  }
  shapes_.push_back(parts_.Of(solid));
  const objects::Box box = objects::Bounds(solid, pose.orientation);
  const Vector3d margin = Vector3d::Constant(0.02);
  boxes_.push_back({FromEigen(pose.position + box.lower - margin),
                    FromEigen(pose.position + box.upper + margin)});
}

Scene PairScene::View() const {
  return {.size = shapes_.size(),
          .boxes = boxes_,
          .filters = filters_,
          .poses = poses_,
          .shapes = shapes_,
          .is_asleep = {}};
}

namespace {

/// m: how far a point is from the surface of a convex solid.
double FromSurface(const Solid& solid, const objects::Pose& pose, const Vector3d& point) {
  const Solid probe{Shape::kEllipsoid, Vector3d::Constant(2e-6 * solid.sides.maxCoeff())};
  const auto found = exact::DistanceOf(probe, {point}, solid, pose);
  return std::abs(found.gap + 1e-6 * solid.sides.maxCoeff());
}

/// The faults of one pair.
class PairJudge {
 public:
  PairJudge(const PairCase& pair, const ExactContact& exact, int index, bool judges_surface,
            Faults& faults)
      : pair_(pair),
        exact_(exact),
        index_(index),
        judges_surface_(judges_surface),
        size_(SizeOf(pair)),
        faults_(faults) {}

  void Add(const Contact& contact) {
    const Vector3d normal = ToEigen(contact.normal), on_a = ToEigen(contact.on_a),
                   on_b = ToEigen(contact.on_b);
    const double apart = (on_a - on_b - contact.distance * normal).norm();
    const double slop = 1e-9 * (on_a.norm() + on_b.norm() + size_);
    const bool is_valid = std::isfinite(contact.distance) && std::abs(normal.norm() - 1) < 1e-6 &&
                          apart < 1e-6 * size_ + slop;
    faults_.invalid += !is_valid;
    if (deepest_ == nullptr || contact.distance < deepest_->distance) deepest_ = &contact;
    if (!judges_surface_ || !is_valid) return;
    if (!pair_.a.compound) Surface(FromSurface(pair_.a, pair_.pose_a, on_a) / size_);
    if (!pair_.is_plane && !pair_.b.compound)
      Surface(FromSurface(pair_.b, pair_.pose_b, on_b) / size_);
  }

  void Finish() {
    ++faults_.pairs;
    const bool overlaps = exact_.gap < -1e-6 * size_;
    const bool is_found = deepest_ != nullptr && deepest_->distance < 0;
    faults_.overlaps += overlaps;
    if (overlaps && !is_found) ++faults_.missed, faults_.worst_pair = index_;
    if (exact_.gap > 1e-6 * size_) {
      faults_.phantom += is_found;
      if (is_found && faults_.missed == 0) faults_.worst_pair = index_;
      faults_.near += exact_.gap < 0.0199;
      faults_.missed_near += exact_.gap < 0.0199 && deepest_ == nullptr;
    }
    if (deepest_ == nullptr || !overlaps || !is_found) return;
    Depth(std::abs(deepest_->distance - exact_.gap) / size_);
    if (pair_.a.PieceCount() > 1 || pair_.b.PieceCount() > 1) return;  // several normals
    const Vector3d normal = ToEigen(deepest_->normal);
    const double excess = (exact_.gap - GapAlong(pair_, normal)) / size_;
    faults_.worst_excess = std::max(faults_.worst_excess, excess);
    const double angle = std::atan2(normal.cross(exact_.normal).norm(), normal.dot(exact_.normal));
    // A normal with no more overlap is as good, such as any of balls with one centre.
    if (angle > 1e-6 && (excess < 1e-6 || !HasOneNormal())) return;
    faults_.normals.push_back(angle);
    faults_.worst_normal = std::max(faults_.worst_normal, angle);
  }

 private:
  void Surface(double distance) {
    faults_.surfaces.push_back(distance);
    if (!(distance > faults_.worst_surface)) return;
    faults_.worst_surface = distance;
    faults_.worst_place = index_;
  }
  void Depth(double error) {
    faults_.depths.push_back(error);
    faults_.inexact += error > 1e-6;
    faults_.worst_relative =
        std::max(faults_.worst_relative, error / std::max(1e-3, -exact_.gap / size_));
    if (error > faults_.worst_depth) {
      faults_.worst_depth = error;
      if (faults_.missed + faults_.phantom == 0) faults_.worst_pair = index_;
    }
  }
  bool HasOneNormal() const {
    const auto distance = exact::DistanceOf(pair_.a, pair_.pose_a, pair_.b, pair_.pose_b);
    return exact::HasOneNormal(pair_.a, pair_.pose_a, pair_.b, pair_.pose_b, distance, 0.01);
  }

  const PairCase& pair_;
  const ExactContact& exact_;
  const int index_;
  const bool judges_surface_;
  const double size_;
  Faults& faults_;
  const Contact* deepest_ = nullptr;
};

}  // namespace

double Quantile(std::vector<double> values, double part) {
  if (values.empty()) return 0;
  const auto place = static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, values.begin() + place);
  return values[static_cast<std::size_t>(place)];
}

void Faults::Add(const Faults& others, int first) {
  const auto rank = [](const Faults& of) {
    return std::tuple(of.missed > 0, of.phantom > 0, of.worst_depth);
  };
  if (others.worst_pair >= 0 && (worst_pair < 0 || rank(others) > rank(*this)))
    worst_pair = first + others.worst_pair;
  if (others.worst_place >= 0 && (worst_place < 0 || others.worst_surface > worst_surface))
    worst_place = first + others.worst_place;
  pairs += others.pairs;
  overlaps += others.overlaps;
  near += others.near;
  missed += others.missed;
  missed_near += others.missed_near;
  phantom += others.phantom;
  invalid += others.invalid;
  inexact += others.inexact;
  depths.insert(depths.end(), others.depths.begin(), others.depths.end());
  normals.insert(normals.end(), others.normals.begin(), others.normals.end());
  surfaces.insert(surfaces.end(), others.surfaces.begin(), others.surfaces.end());
  worst_depth = std::max(worst_depth, others.worst_depth);
  worst_normal = std::max(worst_normal, others.worst_normal);
  worst_relative = std::max(worst_relative, others.worst_relative);
  worst_excess = std::max(worst_excess, others.worst_excess);
  worst_surface = std::max(worst_surface, others.worst_surface);
}

Faults Judge(Detector& detector, const std::vector<PairCase>& pairs,
             const std::vector<ExactContact>& exact, const Detector* other, int every) {
  const PairScene bodies(pairs);
  const Scene scene = bodies.View();
  detector.Prepare(scene);
  Faults faults;
  std::vector<Contact> contacts;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Pair& pair = bodies.pairs()[i];
    if (!exact[i].is_tight || !detector.Handles(scene, pair.a, pair.b)) continue;
    if (other != nullptr && !other->Handles(scene, pair.a, pair.b)) continue;
    contacts.clear();
    detector.FindContacts(scene, {&pair, 1}, contacts);
    const auto index = static_cast<int>(i);
    PairJudge judge(pairs[i], exact[i], index, index % every == 0, faults);
    for (const Contact& contact : contacts) judge.Add(contact);
    judge.Finish();
  }
  return faults;
}

}  // namespace cdb::tests
