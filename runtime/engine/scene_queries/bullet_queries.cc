// Queries by Bullet's own functions. A ray finds convex shapes by btSubsimplexConvexCast, whose
// answers are inexact (https://github.com/bulletphysics/bullet3/issues/4464).

#include "dsl/text/check.h"
#include "library/layouts/initial_state.h"
#include "runtime/engine/scene_queries/queries.h"
#include "runtime/engine/world/conversions.h"

namespace cdb::scene_queries {
namespace {

/// Keeps the hits of one query that Bullet reports, as the mode asks. The pieces of a body come one
/// after the other.
class Collector {
 public:
  Collector(queries::Hits mode, double length, std::vector<queries::Hit<double>>& hits)
      : mode_(mode), length_(length), hits_(hits), first_(hits.size()) {}

  /// Returns the fraction up to which the search goes on.
  btScalar Add(const btCollisionObject& body, btScalar fraction, const btVector3& normal,
               btScalar most) {
    const queries::Hit<double> hit = {body.getUserIndex(), length_ * static_cast<double>(fraction),
                                      world::ToEigen(normal)};
    const bool is_next_piece = hits_.size() > first_ && hits_.back().body == hit.body;
    if (mode_ != queries::Hits::kAll) {
      hits_.resize(first_);
      hits_.push_back(hit);
      return mode_ == queries::Hits::kAny ? btScalar(0) : fraction;
    }
    if (!is_next_piece)
      hits_.push_back(hit);
    else if (hit.distance < hits_.back().distance)
      hits_.back() = hit;
    return most;
  }

 private:
  const queries::Hits mode_;
  const double length_;
  std::vector<queries::Hit<double>>& hits_;
  const std::size_t first_;
};

btVector3 InWorldAxes(const btCollisionObject& body, const btVector3& normal, bool is_already) {
  return is_already ? normal : body.getWorldTransform().getBasis() * normal;
}

// Filters of contacts do not hide bodies from queries.

class RayHits final : public btCollisionWorld::RayResultCallback {
 public:
  explicit RayHits(Collector collector) : collector_(collector) {}
  bool needsCollision(btBroadphaseProxy*) const override { return true; }
  btScalar addSingleResult(btCollisionWorld::LocalRayResult& result, bool in_world) override {
    m_collisionObject = result.m_collisionObject;
    return m_closestHitFraction =
               collector_.Add(*m_collisionObject, result.m_hitFraction,
                              InWorldAxes(*m_collisionObject, result.m_hitNormalLocal, in_world),
                              m_closestHitFraction);
  }

 private:
  Collector collector_;
};

class SweepHits final : public btCollisionWorld::ConvexResultCallback {
 public:
  explicit SweepHits(Collector collector) : collector_(collector) {}
  bool needsCollision(btBroadphaseProxy*) const override { return true; }
  btScalar addSingleResult(btCollisionWorld::LocalConvexResult& result, bool in_world) override {
    const btCollisionObject& body = *result.m_hitCollisionObject;
    return m_closestHitFraction = collector_.Add(
               body, result.m_hitFraction, InWorldAxes(body, result.m_hitNormalLocal, in_world),
               m_closestHitFraction);
  }

 private:
  Collector collector_;
};

class Overlaps final : public btCollisionWorld::ContactResultCallback {
 public:
  explicit Overlaps(Collector collector) : collector_(collector) {}
  bool needsCollision(btBroadphaseProxy*) const override { return !is_over_; }
  btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper*, int, int,
                           const btCollisionObjectWrapper* body, int, int) override {
    // Bullet reports contacts some way apart, too.
    if (point.getDistance() <= 0)
      is_over_ = collector_.Add(*body->getCollisionObject(), 0, btVector3(0, 0, 0), 1) == 0;
    return 0;
  }

 private:
  Collector collector_;
  bool is_over_ = false;
};

}  // namespace

BulletQueries::BulletQueries(const world::Engine& engine, const QueryBlock& block)
    : world_(const_cast<world::Engine&>(engine).world()), block_(block) {
  for (const queries::Ray<double>& ray : block.rays)
    rays_.emplace_back(world::ToBullet(ray.from),
                       world::ToBullet(Eigen::Vector3d(ray.from + ray.length * ray.along)));
  if (block.type != schema::QueryType::kRay)
    object_.setCollisionShape(shapes_.Get(block.shape, layouts::kBulletMargin));
}

void BulletQueries::Ask(Answers& answers) {
  for (std::size_t i = 0; i < rays_.size(); ++i) {
    switch (block_.type) {
      case schema::QueryType::kRay:
        Cast(i, answers);
        break;
      case schema::QueryType::kSweep:
        Sweep(i, answers);
        break;
      case schema::QueryType::kOverlap:
        Overlap(i, answers);
        break;
      case schema::QueryType::kNearest:
        CDB_CHECK(false);  // refused by analysis::FindQueryFault
    }
    answers.ends.push_back(answers.hits.size());
  }
}

void BulletQueries::Cast(std::size_t query, Answers& answers) {
  RayHits hits({block_.hits, block_.rays[query].length, answers.hits});
  world_.rayTest(rays_[query].first, rays_[query].second, hits);
}

void BulletQueries::Sweep(std::size_t query, Answers& answers) {
  SweepHits hits({block_.hits, block_.rays[query].length, answers.hits});
  const btMatrix3x3& unturned = btMatrix3x3::getIdentity();
  world_.convexSweepTest(static_cast<const btConvexShape*>(object_.getCollisionShape()),
                         btTransform(unturned, rays_[query].first),
                         btTransform(unturned, rays_[query].second), hits);
}

void BulletQueries::Overlap(std::size_t query, Answers& answers) {
  object_.setWorldTransform(btTransform(btMatrix3x3::getIdentity(), rays_[query].first));
  Overlaps hits({block_.hits, 0, answers.hits});
  world_.contactTest(&object_, hits);
}

}  // namespace cdb::scene_queries
