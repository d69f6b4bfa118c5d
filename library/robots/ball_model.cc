#include "library/robots/ball_model.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "compiler/analysis/expectation.h"
#include "compiler/schema/parametrised_words.h"
#include "library/exact/signed_distance.h"
#include "library/layouts/joint_pairs.h"
#include "library/scene_error.h"

namespace cdb::robots {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using layouts::ObjectState;

/// Appends the shape of one part, or of a solid without parts, in the frame of its origin. False if
/// it is none of those that can be checked.
bool AddShape(std::string_view type, const Vector3d& sides, const Vector3d& at,
              const Matrix3d& turn, std::vector<Obstacle>& shapes) {
  Obstacle shape = {at, turn, sides / 2, 0, 0, 0};
  if (type == "cuboid") {
  } else if (type == "sphere" && sides.x() == sides.y() && sides.y() == sides.z()) {
    shape.half.setZero();
    shape.radius = sides.x() / 2;
  } else if (type == "capsule" && sides.x() == sides.z() && sides.y() >= sides.x()) {
    shape.half = {0, (sides.y() - sides.x()) / 2, 0};
    shape.radius = sides.x() / 2;
  } else if (type == "cylinder" && sides.x() == sides.z()) {
    shape.disc = sides.x() / 2;
  } else {
    return false;
  }
  shapes.push_back(shape);
  return true;
}

bool AddPart(const schema::Call& part, std::vector<Obstacle>& shapes) {
  const auto vector = [&](const char* argument) {
    return schema::AsVector(schema::ArgumentOf(part, argument));
  };
  const schema::Word* type = schema::AsWord(schema::ArgumentOf(part, "type"));
  if (type == nullptr || vector("sides") == nullptr || vector("scale") != nullptr) return false;
  const Vector3d zero = Vector3d::Zero();
  const Vector3d at = vector("at") != nullptr ? *vector("at") : zero;
  const Vector3d turn = vector("turn") != nullptr ? *vector("turn") : zero;
  return AddShape(type->text, *vector("sides"), at, layouts::TurnAbout(turn).toRotationMatrix(),
                  shapes);
}

/// The shapes of an object, in the frame of its origin. Throws SceneError if there is another one.
std::vector<Obstacle> ShapesOf(const plan::Group& group, const ObjectState& object) {
  std::vector<Obstacle> shapes;
  bool good = true;
  const schema::Value& type = group.settings.Get("type");
  if (const schema::Call* call = schema::AsCall(type)) {
    const std::span<const schema::Value> parts = schema::PartsOf(*call);
    good = !parts.empty() && group.settings.WordOr("size") == "native" &&
           std::get<schema::Ratio>(group.settings.Get("aspect")).parts == Vector3d::Ones();
    for (const schema::Value& part : parts) good = good && AddPart(*schema::AsCall(part), shapes);
  } else if (object.solid.compound == nullptr) {
    good = AddShape(objects::TypeOf(object.solid.shape), object.solid.sides, Vector3d::Zero(),
                    Matrix3d::Identity(), shapes);
  } else {
    good = false;
  }
  if (good) return shapes;
  throw library::SceneError(
      fmt::format("configurations.by lanes checks cuboids, spheres, round capsules and "
                  "cylinders, and compounds of these, but {} is another shape",
                  group.name),
      "write configurations.by detector", group.name, "type");
}

Ball BoundOf(const std::vector<Ball>& balls) {
  Eigen::AlignedBox3d box;
  for (const Ball& ball : balls) {
    box.extend(ball.centre - Vector3d::Constant(ball.radius));
    box.extend(ball.centre + Vector3d::Constant(ball.radius));
  }
  Ball bound = {box.center(), 0};
  for (const Ball& ball : balls)
    bound.radius = std::max(bound.radius, (ball.centre - bound.centre).norm() + ball.radius);
  bound.radius *= 1 + 1e-12;
  return bound;
}

void AddLink(const plan::Group& group, std::size_t object, const std::vector<Obstacle>& shapes,
             BallModel& model) {
  BallModel::Link link = {object, {}, {}};
  for (const Obstacle& shape : shapes) {
    if (!shape.half.isZero(0) || shape.disc > 0)
      throw library::SceneError(
          fmt::format("configurations.by lanes checks links that are balls, but {} has another "
                      "shape",
                      group.name),
          "write configurations.by detector, or spheres in the file of the robot", group.name,
          "type");
    link.balls.push_back({shape.centre, shape.radius});
  }
  link.bound = BoundOf(link.balls);
  model.links.push_back(std::move(link));
}

}  // namespace

BallModel BallModelOf(const plan::Scene& scene, const layouts::InitialState& state,
                      const KinematicTree& tree) {
  if (scene.world.WordOr("world.walls") != "none")
    throw library::SceneError("configurations.by lanes checks no walls",
                              "write world.walls none, and boxes in their place", "",
                              "world.walls");
  const analysis::Collisions collisions(scene);
  BallModel model;
  const auto touches_nothing = [&](std::size_t group) {
    for (std::size_t other = 0; other < scene.groups.size(); ++other)
      if (collisions.MayTouch(group, other)) return false;
    return true;
  };
  std::vector<char> moves(state.objects.size(), 0);
  for (const std::size_t object : tree.moved()) {
    moves[object] = 1;
    const std::size_t group = state.objects[object].group;
    if (!touches_nothing(group))
      AddLink(scene.groups[group], object, ShapesOf(scene.groups[group], state.objects[object]),
              model);
  }
  for (std::size_t i = 0; i < state.objects.size(); ++i) {
    const ObjectState& object = state.objects[i];
    if (moves[i] != 0 || touches_nothing(object.group)) continue;
    const objects::Pose origin = objects::OriginOf(object.solid, object.pose);
    for (Obstacle shape : ShapesOf(scene.groups[object.group], object)) {
      shape.centre = origin.position + origin.orientation * shape.centre;
      shape.axes = origin.orientation.toRotationMatrix() * shape.axes;
      shape.object = i;
      model.obstacles.push_back(shape);
    }
  }
  const std::vector<layouts::JointPair> joints = layouts::JointPairsOf(scene);
  const auto may_touch = [&](std::size_t a, std::size_t b) {
    return collisions.MayTouch(state.objects[a].group, state.objects[b].group) &&
           std::ranges::none_of(joints, [&](const layouts::JointPair& pair) {
             return std::minmax(pair.parent, pair.child) == std::minmax(a, b);
           });
  };
  for (std::size_t link = 0; link < model.links.size(); ++link) {
    for (std::size_t i = 0; i < model.obstacles.size(); ++i)
      if (may_touch(model.links[link].object, model.obstacles[i].object))
        model.with_obstacles.emplace_back(link, i);
    for (std::size_t other = link + 1; other < model.links.size(); ++other)
      if (may_touch(model.links[link].object, model.links[other].object))
        model.with_links.emplace_back(link, other);
  }
  return model;
}

namespace {

/// Those of each link, in the world.
std::vector<std::vector<Ball>> PlacedBalls(const BallModel& model,
                                           const std::vector<ObjectState>& objects,
                                           const std::vector<objects::Pose>& poses) {
  std::vector<std::vector<Ball>> balls;
  for (const BallModel::Link& link : model.links) {
    const objects::Pose origin = objects::OriginOf(objects[link.object].solid, poses[link.object]);
    balls.push_back(link.balls);
    for (Ball& ball : balls.back())
      ball.centre = origin.position + origin.orientation * ball.centre;
  }
  return balls;
}

/// A ball, a box or a capsule as the referee takes it.
struct Placed {
  objects::Solid solid;
  objects::Pose pose;

  explicit Placed(const Ball& ball)
      : solid{objects::Shape::kEllipsoid, Vector3d::Constant(2 * ball.radius)},
        pose{ball.centre, Eigen::Quaterniond::Identity()} {}
  explicit Placed(const Obstacle& of)
      : solid{of.disc > 0         ? objects::Shape::kCylinder
              : of.radius == 0    ? objects::Shape::kCuboid
              : of.half.isZero(0) ? objects::Shape::kEllipsoid
                                  : objects::Shape::kCapsule,
              2 * (of.half + Vector3d::Constant(of.radius))},
        pose{of.centre, Eigen::Quaterniond(of.axes).normalized()} {}
};

/// Adds up what the referee says of pairs.
class Verdict {
 public:
  void Add(const Placed& a, const Placed& b) {
    const exact::SignedDistance distance = exact::DistanceOf(a.solid, a.pose, b.solid, b.pose, 0);
    hits_ = hits_ || distance.upper <= 0;
    is_open_ = is_open_ || distance.lower <= 0;
  }
  bool hits() const { return hits_; }
  std::optional<bool> Answer() const {
    return hits_ ? std::optional(true) : is_open_ ? std::nullopt : std::optional(false);
  }

 private:
  bool hits_ = false, is_open_ = false;
};

/// m: the referee is not asked of shapes that are this far apart in double.
constexpr double kFarApart = 1e-6;

}  // namespace

std::optional<bool> HitsExactly(const BallModel& model, const std::vector<ObjectState>& objects,
                                const std::vector<objects::Pose>& poses) {
  const std::vector<std::vector<Ball>> balls = PlacedBalls(model, objects, poses);
  Verdict verdict;
  for (const auto& [link, other] : model.with_obstacles) {
    const Obstacle& obstacle = model.obstacles[other];
    for (const Ball& ball : balls[link])
      if (std::sqrt(obstacle.SquaredDistance(ball.centre)) <=
          ball.radius + obstacle.radius + kFarApart)
        verdict.Add(Placed(ball), Placed(obstacle));
    if (verdict.hits()) return true;
  }
  for (const auto& [link, other] : model.with_links) {
    for (const Ball& a : balls[link])
      for (const Ball& b : balls[other])
        if ((a.centre - b.centre).norm() <= a.radius + b.radius + kFarApart)
          verdict.Add(Placed(a), Placed(b));
    if (verdict.hits()) return true;
  }
  return verdict.Answer();
}

bool HitsInDouble(const BallModel& model, const std::vector<ObjectState>& objects,
                  const std::vector<objects::Pose>& poses) {
  const std::vector<std::vector<Ball>> balls = PlacedBalls(model, objects, poses);
  for (const auto& [link, other] : model.with_obstacles) {
    const Obstacle& obstacle = model.obstacles[other];
    for (const Ball& ball : balls[link]) {
      const double reach = ball.radius + obstacle.radius;
      if (obstacle.SquaredDistance(ball.centre) <= reach * reach) return true;
    }
  }
  for (const auto& [link, other] : model.with_links)
    for (const Ball& a : balls[link])
      for (const Ball& b : balls[other]) {
        const double reach = a.radius + b.radius;
        if ((a.centre - b.centre).squaredNorm() <= reach * reach) return true;
      }
  return false;
}

}  // namespace cdb::robots
