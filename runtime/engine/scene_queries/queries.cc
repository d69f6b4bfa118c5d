#include "runtime/engine/scene_queries/queries.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "compiler/analysis/queries.h"
#include "library/distributions/draw.h"
#include "library/scene_error.h"
#include "runtime/engine/world/conversions.h"
#include "runtime/engine/world/timed_world.h"

namespace cdb::scene_queries {
namespace {

using distributions::Draw;
using Eigen::Vector3d;
using schema::QueryType;

queries::Hits HitsOf(QueryType type, std::string_view word) {
  if (type == QueryType::kNearest) return queries::Hits::kClosest;
  if (word == "any") return queries::Hits::kAny;
  // No body that overlaps is closer than another.
  return word == "all" || type == QueryType::kOverlap ? queries::Hits::kAll
                                                      : queries::Hits::kClosest;
}

/// The shape of the block, not turned.
objects::Solid ShapeOf(const plan::Queries& block) {
  objects::Solid shape{objects::ShapeOf(block.settings.WordOr("queries.shape"))};
  const auto& aspect = std::get<schema::Ratio>(block.settings.Get("queries.aspect"));
  shape.sides = block.settings.Real("queries.size") * aspect.parts;
  return shape;
}

/// Draws one query after the other.
class QueryDraw {
 public:
  QueryDraw(const plan::Scene& scene, const plan::Queries& block)
      : block_(block),
        type_(analysis::TypeOf(block)),
        side_(scene.world.Real("world.side")),
        from_(scene, block, "queries.from"),
        direction_(scene, block, "queries.direction"),
        length_(scene, block, "queries.length"),
        to_(scene, block, "queries.to") {}

  queries::Ray<double> Next() {
    const Vector3d from = From();
    if (!analysis::Moves(type_))
      return {world::RoundedForBullet(from), Vector3d::UnitX(), Length()};
    std::string_view word;
    const std::optional<Vector3d> end = to_.VectorOrWord(&word);
    return Rounded(from, end ? *end : Vector3d(from + Direction() * Length()));
  }

 private:
  Vector3d From() {
    std::string_view word;
    if (const auto from = from_.VectorOrWord(&word)) return *from;
    Vector3d place;
    for (double& coordinate : place) coordinate = from_.stream().Uniform(-side_ / 2, side_ / 2);
    return place;
  }
  Vector3d Direction() {
    std::string_view word;
    for (int tries = 0; tries < distributions::Draw::kMaxRedraws; ++tries) {
      const auto direction = direction_.VectorOrWord(&word);
      if (!direction) {
        // All directions are alike in a vector of normal numbers.
        Vector3d normal;
        for (double& component : normal) component = direction_.stream().Normal();
        if (normal.norm() > 1e-3) return normal.normalized();
      } else if (direction->norm() > 0) {
        return direction->normalized();
      }
    }
    throw library::SceneError("`queries.direction`: all directions that were drawn are 0");
  }
  double Length() {
    std::string_view word;
    return length_.RealOrWord(&word).value_or(side_);
  }
  /// Both ends in Bullet's precision, so that all implementations get the same query.
  queries::Ray<double> Rounded(const Vector3d& from, const Vector3d& to) const {
    const Vector3d begin = world::RoundedForBullet(from), end = world::RoundedForBullet(to);
    const double length = (end - begin).norm();
    if (!(length > 0) || !std::isfinite(length))
      throw library::SceneError(
          analysis::TextOf(block_) + " have a way whose end is its start, or out of reach",
          "change from, to or length", block_.name, "queries.from");
    return {begin, (end - begin) / length, length};
  }

  const plan::Queries& block_;
  const QueryType type_;
  const double side_;
  Draw from_, direction_, length_, to_;
};

template <typename Real>
queries::Ray<Real> As(const queries::Ray<double>& ray) {
  return {ray.from.cast<Real>(), ray.along.cast<Real>(), static_cast<Real>(ray.length)};
}

}  // namespace

std::vector<QueryBlock> DrawQueries(const plan::Scene& scene) {
  std::vector<QueryBlock> blocks;
  for (const plan::Queries& block : scene.queries) {
    QueryBlock& made = blocks.emplace_back();
    made.name = block.name;
    made.type = analysis::TypeOf(block);
    made.hits = HitsOf(made.type, block.settings.WordOr("queries.hits"));
    made.shape = ShapeOf(block);
    made.by_tree = block.settings.WordOr("queries.implementation") == "tree";
    made.every = block.settings.Count("queries.every");
    QueryDraw draw(scene, block);
    const std::uint64_t count = block.settings.Count("queries.count");
    made.rays.reserve(count);
    for (std::uint64_t i = 0; i < count; ++i) made.rays.push_back(draw.Next());
  }
  return blocks;
}

TreeQueries::TreeQueries(const world::Engine& engine) {
  const auto& objects = engine.initial_state().objects;
  for (std::size_t i = 0; i < objects.size(); ++i) Add(objects[i].solid, *engine.objects()[i]);
  for (const auto& wall : engine.walls()) {
    if (const auto plane = world::PlaneOf(*wall))
      tree_.AddHalfSpace(plane->normal.cast<btScalar>(), static_cast<btScalar>(plane->offset),
                         wall->getUserIndex());
    else
      Add(world::BoxWallSolid(*wall), *wall);
  }
}

void TreeQueries::Add(const objects::Solid& solid, const btRigidBody& body) {
  tree_.Add(solid, body.getUserIndex());
  bodies_.push_back(&body);
  poses_.push_back(body.getWorldTransform());
  Move(bodies_.size() - 1);
}

void TreeQueries::Move(std::size_t index) {
  const btTransform& pose = poses_[index];
  queries::SceneTree<btScalar>::Axes axes;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) axes(row, column) = pose.getBasis()[row][column];
  tree_.Move(index, {pose.getOrigin().x(), pose.getOrigin().y(), pose.getOrigin().z()}, axes);
}

void TreeQueries::Update() {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const btTransform& pose = bodies_[i]->getWorldTransform();
    if (pose == poses_[i]) continue;
    poses_[i] = pose;
    Move(i);
  }
  tree_.Update();
}

void TreeQueries::Ask(const QueryBlock& block, std::span<const queries::Ray<btScalar>> rays,
                      Answers& answers) {
  for (std::size_t i = 0; i < rays.size(); ++i) {
    found_.clear();
    const queries::Ray<double>& way = block.rays[i];
    const queries::Placed at = {block.shape, way.from};
    switch (block.type) {
      case QueryType::kRay:
        tree_.Cast(rays[i], block.hits, found_);
        break;
      case QueryType::kSweep:
        tree_.Sweep(at, way.along, way.length, block.hits, found_);
        break;
      case QueryType::kOverlap:
        tree_.Overlap(at, block.hits, found_);
        break;
      case QueryType::kNearest:
        tree_.Nearest(at, way.length, found_);
        break;
    }
    for (const queries::Hit<btScalar>& hit : found_)
      answers.hits.push_back(
          {hit.body, static_cast<double>(hit.distance), hit.normal.template cast<double>()});
    answers.ends.push_back(answers.hits.size());
  }
}

Queries::Queries(const plan::Scene& scene, const world::Engine& engine,
                 protocol::Recording& recording)
    : recording_(recording),
      blocks_(DrawQueries(scene)),
      asked_(blocks_.size()),
      is_timed_(engine.timed_world() != nullptr) {
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    asked_[i].answers.ends.reserve(blocks_[i].rays.size());
    if (!blocks_[i].by_tree) {
      asked_[i].by_bullet = std::make_unique<BulletQueries>(engine, blocks_[i]);
      continue;
    }
    if (tree_ == nullptr) tree_ = std::make_unique<TreeQueries>(engine);
    for (const queries::Ray<double>& ray : blocks_[i].rays)
      asked_[i].rays_for_tree.push_back(As<btScalar>(ray));
  }
}

Queries::~Queries() = default;

void Queries::Ask(std::uint64_t cycle) {
  const auto now = [this] { return is_timed_ ? world::Now() : 0; };
  bool is_updated = false;
  update_time_ = 0;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    Asked& asked = asked_[i];
    asked.answers.Clear();
    asked.is_due = cycle % blocks_[i].every == 0;
    if (!asked.is_due) continue;
    if (blocks_[i].by_tree && !is_updated) {
      const std::int64_t begin = now();
      tree_->Update();
      update_time_ = static_cast<double>(now() - begin);
      is_updated = true;
    }
    const std::int64_t begin = now();
    if (blocks_[i].by_tree)
      tree_->Ask(blocks_[i], asked.rays_for_tree, asked.answers);
    else
      asked.by_bullet->Ask(asked.answers);
    asked.time = static_cast<double>(now() - begin);
  }
}

void Queries::Record(std::uint64_t cycle) {
  std::array<double, protocol::kQueryTypeCount> times = {};
  std::array<std::int32_t, protocol::kQueryTypeCount> counts = {}, hits = {};
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    if (!asked_[i].is_due) continue;
    const auto type = static_cast<std::size_t>(blocks_[i].type);
    times[type] += asked_[i].time;
    counts[type] += static_cast<std::int32_t>(asked_[i].answers.ends.size());
    hits[type] += static_cast<std::int32_t>(asked_[i].answers.hits.size());
  }
  recording_.PutRow("query_time", cycle, times);
  recording_.Put("query_update_time", cycle, update_time_);
  recording_.PutRow("query_count", cycle, counts);
  recording_.PutRow("query_hits", cycle, hits);
  const auto all = recording_.Reals("answers");
  if (all.empty()) return;
  std::size_t rows = 0;
  for (const QueryBlock& block : blocks_) rows += block.rays.size();
  std::size_t row = cycle * rows;
  for (std::size_t i = 0; i < blocks_.size(); ++i)
    for (std::size_t query = 0; query < blocks_[i].rays.size(); ++query, ++row) {
      if (!asked_[i].is_due) continue;
      const auto answer = asked_[i].answers.Of(query);
      if (answer.empty()) continue;
      const auto& hit = *std::ranges::min_element(answer, {}, &queries::Hit<double>::distance);
      const double parts[] = {static_cast<double>(hit.body), hit.distance, hit.normal.x(),
                              hit.normal.y(), hit.normal.z()};
      static_assert(std::size(parts) == protocol::kAnswerSize);
      std::ranges::copy(parts, all.begin() + static_cast<std::ptrdiff_t>(row * std::size(parts)));
    }
}

}  // namespace cdb::scene_queries
