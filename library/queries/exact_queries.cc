#include "library/queries/exact_queries.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "dsl/text/check.h"
#include "library/objects/distance.h"

namespace cdb::queries {
namespace {

using Eigen::Vector3d;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

void ExactQueries::Add(Body body) {
  const LineShape<double>& shape = shapes_.Get(body.solid);
  const double radius = body.solid.OuterRadius();
  bodies_.push_back({std::move(body), &shape, radius});
}

std::vector<ExactHit> ExactQueries::Find(const Ray<double>& ray, double slack) const {
  std::vector<ExactHit> found;
  const auto is_near = [&](double distance) {
    return distance >= -slack && distance <= ray.length + slack;
  };
  for (const HalfSpace& space : half_spaces_) {
    Chord<double> chord;
    chord.Cut(ray.from, ray.along, space.normal, space.offset);
    if (!chord.IsNone() && is_near(chord.enter))
      found.push_back({space.id, chord.enter, kInfinity, 1, space.normal, kInfinity});
  }
  for (const Row& row : bodies_) {
    const Vector3d to_body = row.body.pose.position - ray.from;
    const double nearest = std::clamp(to_body.dot(ray.along), 0.0, ray.length);
    const double reach = row.radius * (1 + 1e-9) + 2 * slack;
    if ((to_body - nearest * ray.along).squaredNorm() > reach * reach) continue;
    const Eigen::Quaterniond back = row.body.pose.orientation.conjugate();
    row.shape->ForEveryChord(
        Vector3d(back * -to_body), Vector3d(back * ray.along),
        [&](const Chord<double>& chord, double margin) {
          if (!is_near(chord.enter)) return;
          const double inside = row.body.solid.IsSurface() ? kInfinity : chord.leave - chord.enter;
          found.push_back({row.body.id, chord.enter, inside, margin,
                           (row.body.pose.orientation * chord.normal).normalized(),
                           row.body.solid.sides.maxCoeff()});
        });
  }
  std::ranges::stable_sort(found, {}, &ExactHit::distance);
  return found;
}

template <typename Visit>
void ExactQueries::ForBodies(const Placed& from, const Vector3d& way, double reach,
                             Visit visit) const {
  for (const HalfSpace& space : half_spaces_)
    visit(space.id, kInfinity,
          [&](const auto&, const auto& by_half_space) { return by_half_space(space.exact()); });
  const double length = way.squaredNorm();
  for (const Row& row : bodies_) {
    const Vector3d to_body = row.body.pose.position - from.position;
    const double part = length > 0 ? std::clamp(to_body.dot(way) / length, 0.0, 1.0) : 0;
    const double near = (row.radius + from.solid.OuterRadius()) * (1 + 1e-9) + reach;
    if ((to_body - part * way).squaredNorm() > near * near) continue;
    visit(row.body.id, row.body.solid.sides.maxCoeff(), [&](const auto& by_solid, const auto&) {
      return by_solid(row.body.solid, row.body.pose);
    });
  }
}

std::vector<ExactHit> ExactQueries::FindSwept(const Placed& from, const Vector3d& along,
                                              double length) const {
  std::vector<ExactHit> found;
  ForBodies(from, length * along, 0, [&](std::int32_t id, double size, const auto& test) {
    const std::optional<Touch> touch =
        test([&](const objects::Solid& solid,
                 const objects::Pose& pose) { return SweepTo(from, along, length, solid, pose); },
             [&](const exact::HalfSpace& space) { return SweepTo(from, along, length, space); });
    if (!touch) return;
    // Of a round body: how deep the shape goes into it before it leaves.
    const double steepness = touch->normal.dot(along);
    const double scale = std::isfinite(size) ? size : from.solid.sides.maxCoeff();
    found.push_back(
        {id, touch->distance, steepness * steepness * scale / 2, 1, touch->normal, size});
  });
  std::ranges::stable_sort(found, {}, &ExactHit::distance);
  return found;
}

std::vector<ExactHit> ExactQueries::FindOverlaps(const Placed& at) const {
  std::vector<ExactHit> found;
  ForBodies(at, Vector3d::Zero(), 0, [&](std::int32_t id, double size, const auto& test) {
    const exact::SignedDistance distance = test(
        [&](const objects::Solid& solid, const objects::Pose& pose) {
          return exact::DistanceOf(at.solid, at.pose(), solid, pose, 0);
        },
        [&](const exact::HalfSpace& space) {
          return exact::DistanceOf(at.solid, at.pose(), space);
        });
    if (distance.lower < 0)
      found.push_back({id, 0, std::max(0.0, -distance.upper), 1, Vector3d::Zero(), size});
  });
  return found;
}

std::vector<ExactHit> ExactQueries::FindNear(const Placed& at, double reach) const {
  std::vector<ExactHit> found;
  ForBodies(at, Vector3d::Zero(), reach, [&](std::int32_t id, double size, const auto& test) {
    const std::optional<Touch> touch =
        test([&](const objects::Solid& solid,
                 const objects::Pose& pose) { return queries::DistanceTo(at, reach, solid, pose); },
             [&](const exact::HalfSpace& space) { return queries::DistanceTo(at, reach, space); });
    if (touch) found.push_back({id, touch->distance, kInfinity, 1, touch->normal, size});
  });
  std::ranges::stable_sort(found, {}, &ExactHit::distance);
  return found;
}

double ExactQueries::DistanceOf(std::int32_t body, const Placed& at) const {
  for (const HalfSpace& space : half_spaces_)
    if (space.id == body) return DistanceTo(at, kInfinity, space.exact())->distance;
  const auto row = std::ranges::find(bodies_, body, [](const Row& each) { return each.body.id; });
  CDB_CHECK(row != bodies_.end());
  return objects::Distance(row->body.solid, row->body.pose, at.solid, at.pose());
}

}  // namespace cdb::queries
