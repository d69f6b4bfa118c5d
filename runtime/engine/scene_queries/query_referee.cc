#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "compiler/analysis/queries.h"
#include "dsl/text/check.h"
#include "runtime/engine/scene_queries/queries.h"
#include "runtime/engine/world/conversions.h"

namespace cdb::scene_queries {
namespace {

using Eigen::Vector3d;
using queries::ExactHit;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// A ray that is in a body, or in reach of it, by less than this fraction of its size grazes it.
constexpr double kGraze = 1e-4;
/// A hit farther from a body than this fraction of its size is false, if the ray misses the body.
constexpr double kFalse = 1e-3;

/// Whether everybody must find it: it is neither near an edge of the body, nor does the way begin
/// or end at its surface.
bool IsPlain(const QueryBlock& block, const ExactHit& hit, const queries::Ray<double>& ray,
             double rounding) {
  const double size = std::isfinite(hit.size) ? hit.size : ray.length;
  const double least = kGraze * size + rounding;
  if (block.type == schema::QueryType::kOverlap) return hit.inside > least;
  if (!(hit.distance > least && hit.distance < ray.length - least)) return false;
  if (block.type != schema::QueryType::kRay) return hit.inside > least;
  // The point of a triangle must not be at an edge, where rounding may let a ray through.
  const bool is_steep = std::fabs(hit.normal.dot(ray.along)) > 1e-2 || std::isfinite(hit.inside);
  return hit.inside > least && hit.margin > 1e-3 && is_steep;
}

/// m; walls have the size of the cube.
double SizeOf(const world::Engine& engine, std::int32_t body) {
  const auto& objects = engine.initial_state().objects;
  const auto index = static_cast<std::size_t>(body);
  return index < objects.size() ? objects[index].solid.sides.maxCoeff() : engine.side();
}

double AngleBetween(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace

QueryReferee::QueryReferee(const world::Engine& engine, protocol::Recording& recording)
    : engine_(engine), recording_(recording) {
  const auto& objects = engine.initial_state().objects;
  for (std::size_t i = 0; i < objects.size(); ++i)
    exact_.Add({objects[i].solid, {}, static_cast<std::int32_t>(i)});
  for (const auto& wall : engine.walls()) {
    if (const auto plane = world::PlaneOf(*wall))
      exact_.AddHalfSpace(plane->normal, plane->offset, wall->getUserIndex());
    else
      exact_.Add({world::BoxWallSolid(*wall), world::ExactPose(*wall), wall->getUserIndex()});
  }
}

void QueryReferee::MoveBodies() {
  for (std::size_t i = 0; i < engine_.objects().size(); ++i)
    exact_.Move(i, world::ExactPose(*engine_.objects()[i]));
}

std::vector<ExactHit> QueryReferee::TruthOf(const QueryBlock& block,
                                            const queries::Ray<double>& ray,
                                            double rounding) const {
  const queries::Placed at = {block.shape, ray.from};
  switch (block.type) {
    case schema::QueryType::kRay:
      return exact_.Find(ray, 0.01 * ray.length + rounding);
    case schema::QueryType::kSweep:
      return exact_.FindSwept(at, ray.along, 1.01 * ray.length + rounding);
    case schema::QueryType::kOverlap:
      return exact_.FindOverlaps(at);
    case schema::QueryType::kNearest:
      return exact_.FindNear(at, 1.01 * ray.length + rounding);
  }
  CDB_CHECK(false);
}

void QueryReferee::Compare(const QueryBlock& block, const queries::Ray<double>& ray,
                           std::span<const queries::Hit<double>> answer, Errors& errors) const {
  // Of the numbers that Bullet and cdb's tree compute with.
  const double reach = std::max(ray.from.cwiseAbs().maxCoeff(), 1.0) + ray.length;
  const double rounding = 16 * static_cast<double>(SIMD_EPSILON) * reach;
  const std::vector<ExactHit> truth = TruthOf(block, ray, rounding);
  const queries::Hits hits = block.hits;
  const auto plain = [&](const ExactHit& hit) { return IsPlain(block, hit, ray, rounding); };
  const auto first_plain = std::ranges::find_if(truth, plain);
  // The exact hit of its body that is nearest to an answer; null if there is none.
  const auto same_as = [&](const queries::Hit<double>& hit) {
    const ExactHit* same = nullptr;
    for (const ExactHit& exact : truth)
      if (exact.body == hit.body &&
          (same == nullptr ||
           std::fabs(exact.distance - hit.distance) < std::fabs(same->distance - hit.distance)))
        same = &exact;
    return same;
  };
  // A later hit than `first`: of another body, or of another piece of the same one.
  const auto is_late = [&](const queries::Hit<double>& hit, const ExactHit& first) {
    const double limit = first.distance + 2 * rounding + kFalse * std::min(first.size, ray.length);
    if (hit.body != first.body) return hit.distance > limit;
    return same_as(hit) != &first && same_as(hit)->distance > limit;
  };
  double missed = 0, wrong = 0;
  bool grazes = false;
  // A ball that is lost in rounding.
  const objects::Solid dot = {objects::Shape::kEllipsoid, Vector3d::Constant(1e-12 * reach)};
  const queries::Hit<double>* nearest = nullptr;
  for (const queries::Hit<double>& hit : answer) {
    if (nearest == nullptr || hit.distance < nearest->distance) nearest = &hit;
    const ExactHit* same = same_as(hit);
    if (same == nullptr) {
      const double way = analysis::Moves(block.type) ? hit.distance : 0;
      const objects::Solid& shape = block.type == schema::QueryType::kRay ? dot : block.shape;
      const double apart =
          exact_.DistanceOf(hit.body, {shape, ray.from + way * ray.along}) - rounding;
      if (apart > kFalse * SizeOf(engine_, hit.body))
        ++wrong;
      else
        grazes = true;
      continue;
    }
    if (!plain(*same)) {
      grazes = true;
      continue;
    }
    if (block.type == schema::QueryType::kOverlap) continue;
    errors.distance = std::fmax(errors.distance, std::fabs(same->distance - hit.distance));
    errors.normal = std::fmax(errors.normal, AngleBetween(same->normal, hit.normal));
  }
  if (hits == queries::Hits::kAll) {
    std::set<std::int32_t> seen;
    for (const ExactHit& exact : truth) {
      if (!plain(exact) || !seen.insert(exact.body).second) continue;
      const bool has_distance = block.type != schema::QueryType::kOverlap;
      missed += std::ranges::none_of(answer, [&](const auto& hit) {
        return hit.body == exact.body && !(has_distance && is_late(hit, exact));
      });
    }
  } else if (first_plain != truth.end()) {
    const bool is_behind =
        hits == queries::Hits::kClosest && nearest != nullptr && is_late(*nearest, *first_plain);
    missed += nearest == nullptr || is_behind;
  } else if (nearest == nullptr) {
    grazes = !truth.empty();
  }
  errors.missed += missed;
  errors.wrong += wrong;
  if (missed + wrong > 0 || !grazes) ++errors.compared;
}

void QueryReferee::Compare(const Queries& asked, std::uint64_t cycle) {
  MoveBodies();
  std::array<Errors, protocol::kQueryTypeCount> errors;
  for (Errors& of_type : errors) of_type.distance = of_type.normal = kNone;
  for (std::size_t i = 0; i < asked.blocks().size(); ++i) {
    const QueryBlock& block = asked.blocks()[i];
    const Answers* answers = asked.AnswersTo(i);
    if (answers == nullptr) continue;
    for (std::size_t query = 0; query < block.rays.size(); ++query)
      Compare(block, block.rays[query], answers->Of(query),
              errors[static_cast<std::size_t>(block.type)]);
  }
  const auto put = [&](schema::IntSeries series, double Errors::*count) {
    std::array<std::int32_t, protocol::kQueryTypeCount> counts;
    for (std::size_t type = 0; type < counts.size(); ++type)
      counts[type] = static_cast<std::int32_t>(errors[type].*count);
    recording_.PutRow(series, cycle, counts);
  };
  put("compared_queries", &Errors::compared);
  put("missed_hits", &Errors::missed);
  put("false_hits", &Errors::wrong);
  const auto put_largest = [&](schema::RealSeries series, double Errors::*largest) {
    std::array<double, protocol::kQueryTypeCount> values;
    for (std::size_t type = 0; type < values.size(); ++type) values[type] = errors[type].*largest;
    recording_.PutRow(series, cycle, values);
  };
  put_largest("hit_error", &Errors::distance);
  put_largest("hit_normal_error", &Errors::normal);
}

}  // namespace cdb::scene_queries
