// Queries of the scene between cycles (`queries { }`): asked, timed, recorded, and compared with
// exact answers. They read the world and change nothing in it.
//
// They are asked after the step, about the poses at its end. Bullet finds bodies through the broad
// phase, whose boxes it updates at the start of a step, up to the poses that it predicts for the
// end: it can miss a body that a contact has turned aside.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "library/queries/exact_queries.h"
#include "library/queries/scene_tree.h"
#include "runtime/engine/world/engine.h"
#include "runtime/protocol/recording.h"

namespace cdb::scene_queries {

/// One `queries` block: its queries, drawn once, in Bullet's precision. The ray of a sweep is the
/// way of its shape, that of a shape that stays begins where it is; its length is the reach of a
/// nearest query.
struct QueryBlock {
  std::string name;
  schema::QueryType type;
  queries::Hits hits;
  bool by_tree;
  std::uint64_t every;
  objects::Solid shape;  ///< without a meaning for rays
  std::vector<queries::Ray<double>> rays;
};

/// The blocks of the scene, drawn from its seeds. Throws library::SceneError as drawing does.
std::vector<QueryBlock> DrawQueries(const plan::Scene& scene);

/// The hits of the queries of a block.
struct Answers {
  std::vector<queries::Hit<double>> hits;
  std::vector<std::size_t> ends;  ///< by query: of its hits

  std::span<const queries::Hit<double>> Of(std::size_t query) const {
    const std::size_t begin = query == 0 ? 0 : ends[query - 1];
    return std::span(hits).subspan(begin, ends[query] - begin);
  }
  void Clear() {
    hits.clear();
    ends.clear();
  }
};

/// Answers to one block by Bullet: rayTest, convexSweepTest and contactTest of the world, which has
/// no query for the nearest body. Engine and block must outlive it. Not thread-safe.
class BulletQueries {
 public:
  BulletQueries(const world::Engine& engine, const QueryBlock& block);
  void Ask(Answers& answers);

 private:
  void Cast(std::size_t query, Answers& answers);
  void Sweep(std::size_t query, Answers& answers);
  void Overlap(std::size_t query, Answers& answers);

  btCollisionWorld& world_;
  const QueryBlock& block_;
  /// In Bullet's type, so that no conversion is timed.
  std::vector<std::pair<btVector3, btVector3>> rays_;
  world::ShapePool shapes_;
  btCollisionObject object_;  ///< of an overlap
};

/// Answers by cdb's own tree, in Bullet's precision. The engine must outlive it. Not thread-safe.
class TreeQueries {
 public:
  explicit TreeQueries(const world::Engine& engine);

  /// Takes the bodies' poses over; call before each cycle's queries.
  void Update();
  /// `rays`: those of the block.
  void Ask(const QueryBlock& block, std::span<const queries::Ray<btScalar>> rays, Answers& answers);

 private:
  void Add(const objects::Solid& solid, const btRigidBody& body);
  void Move(std::size_t index);

  queries::SceneTree<btScalar> tree_;
  std::vector<const btRigidBody*> bodies_;  ///< of the tree, by index
  std::vector<btTransform> poses_;          ///< in the tree
  std::vector<queries::Hit<btScalar>> found_;
};

/// Asks every block that is due in a cycle, and records times, counts and answers. Engine and
/// recording must outlive it. Not thread-safe.
class Queries {
 public:
  Queries(const plan::Scene& scene, const world::Engine& engine, protocol::Recording& recording);
  ~Queries();

  /// Call after each recorded step. Takes time stamps only if the scene records timing.
  void Ask(std::uint64_t cycle);
  void Record(std::uint64_t cycle);

  std::span<const QueryBlock> blocks() const { return blocks_; }
  /// Of the last Ask; null if the block was not due.
  const Answers* AnswersTo(std::size_t block) const {
    return asked_[block].is_due ? &asked_[block].answers : nullptr;
  }

 private:
  struct Asked {
    std::unique_ptr<BulletQueries> by_bullet;  ///< or null
    std::vector<queries::Ray<btScalar>> rays_for_tree;
    Answers answers;
    double time = 0;  ///< ns
    bool is_due = false;
  };

  protocol::Recording& recording_;
  const std::vector<QueryBlock> blocks_;
  std::vector<Asked> asked_;  ///< by block
  std::unique_ptr<TreeQueries> tree_;
  double update_time_ = 0;  ///< ns
  const bool is_timed_;
};

/// Compares answers with the truth (`record query_errors`), never in a timed run. Engine and
/// recording must outlive it. Not thread-safe.
class QueryReferee {
 public:
  QueryReferee(const world::Engine& engine, protocol::Recording& recording);

  /// Call after `asked` has been asked in the cycle.
  void Compare(const Queries& asked, std::uint64_t cycle);

 private:
  struct Errors {
    double compared = 0, missed = 0, wrong = 0;  ///< counts; of `wrong`, false hits
    double distance, normal;                     ///< the largest; NaN if there is no hit
  };

  void MoveBodies();
  std::vector<queries::ExactHit> TruthOf(const QueryBlock& block, const queries::Ray<double>& ray,
                                         double rounding) const;
  void Compare(const QueryBlock& block, const queries::Ray<double>& ray,
               std::span<const queries::Hit<double>> answer, Errors& errors) const;

  const world::Engine& engine_;
  protocol::Recording& recording_;
  queries::ExactQueries exact_;
};

}  // namespace cdb::scene_queries
