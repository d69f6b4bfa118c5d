#include "library/robots/lanes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "compiler/analysis/configurations.h"
#include "dsl/text/check.h"
#include "library/robots/lanes_impl.h"

namespace cdb::robots {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A hinge turned farther is checked in double.
constexpr double kMostTurn = 1e6;

void Put(const Vector3d& v, float (&to)[3]) {
  for (int i = 0; i < 3; ++i) to[i] = static_cast<float>(v[i]);
}
void Put(const Matrix3d& m, float (&to)[9]) {
  for (int i = 0; i < 9; ++i) to[i] = static_cast<float>(m(i / 3, i % 3));
}

LaneModel::FloatBall FloatOf(const Ball& ball) {
  LaneModel::FloatBall to = {{}, static_cast<float>(ball.radius)};
  Put(ball.centre, to.centre);
  return to;
}

/// `outer`: the frame of the holder, if it cannot move, and so is that of the world.
LaneModel::Hold FloatOf(const KinematicTree::Hold& hold, std::int32_t parent,
                        const objects::Pose& outer) {
  const Matrix3d turn = outer.orientation.toRotationMatrix(),
                 rest = hold.origin.orientation.toRotationMatrix();
  const auto put_way = [&](const Vector3d& way, float(&to)[3]) { Put(Vector3d(turn * way), to); };
  const auto put_turn = [&](const Matrix3d& by, float(&to)[9]) {
    Put(Matrix3d(turn * by * rest), to);
  };
  LaneModel::Hold to = {parent, -1, hold.is_slider, hold.start, {}, {}};
  Vector3d place = hold.origin.position;
  if (hold.freedom == KinematicTree::Hold::kNone || hold.is_slider) {
    put_turn(Matrix3d::Identity(), to.turn[0]);
    put_way(hold.axis, to.way[1]);
  } else {
    const Vector3d arm = place - hold.at;
    const Matrix3d along = hold.axis * hold.axis.transpose(), across = Matrix3d::Identity() - along;
    Matrix3d cross;
    for (int i = 0; i < 3; ++i) cross.col(i) = hold.axis.cross(Vector3d::Unit(i));
    put_turn(along, to.turn[0]);
    put_turn(across, to.turn[1]);
    put_turn(cross, to.turn[2]);
    put_way(across * arm, to.way[1]);
    put_way(cross * arm, to.way[2]);
    place = hold.at + along * arm;
  }
  if (hold.freedom != KinematicTree::Hold::kNone)
    to.freedom = static_cast<std::int32_t>(hold.freedom);
  Put(Vector3d(outer.position + turn * place), to.way[0]);
  return to;
}

/// An upper bound of the error of a distance: each hold adds a rotation that is off by at most
/// 2^-18, in the norm of Frobenius, and each coordinate is rounded several times.
double ErrorOf(std::size_t depth, double reach, double extent) {
  return std::ldexp(static_cast<double>(depth + 1) * reach, -18) + std::ldexp(reach + extent, -20);
}

class ModelMaker {
 public:
  ModelMaker(const plan::Scene& scene, const layouts::InitialState& state,
             const KinematicTree& tree, const BallModel& balls)
      : scene_(scene), state_(state), tree_(tree), balls_(balls) {}

  LaneModel Make() {
    model_.freedoms = tree_.freedoms();
    AddHolds();
    AddLinks();
    for (const Obstacle& obstacle : balls_.obstacles) Add(obstacle);
    for (const auto& [link, obstacle] : balls_.with_obstacles)
      model_.links[link].obstacles.push_back(static_cast<std::uint32_t>(obstacle));
    for (const auto& [lower, upper] : balls_.with_links)
      model_.links[upper].links.push_back(static_cast<std::uint32_t>(lower));
    model_.error = static_cast<float>(ErrorOf(depth_, reach_, extent_) * (1 + 1e-6));
    return std::move(model_);
  }

 private:
  void AddHolds() {
    const std::vector<analysis::Freedom> freedoms = analysis::FreedomsOf(scene_);
    std::vector<std::size_t> depths;
    std::vector<double> reaches;  // of each hold from the world
    for (const KinematicTree::Hold& hold : tree_.holds()) {
      const auto parent = hold_of_.find(hold.parent);
      const bool is_held = parent != hold_of_.end();
      objects::Pose outer;
      if (!is_held && hold.parent != KinematicTree::Hold::kNone)
        outer =
            objects::OriginOf(state_.objects[hold.parent].solid, state_.objects[hold.parent].pose);
      double way = is_held ? 0 : outer.position.norm();
      way += hold.at.norm() + (hold.origin.position - hold.at).norm();
      if (hold.is_slider && hold.freedom != KinematicTree::Hold::kNone) {
        const analysis::Freedom& freedom = freedoms[hold.freedom];
        way += std::isfinite(freedom.lower) ? freedom.upper - freedom.lower : 0;
      }
      depths.push_back(1 + (is_held ? depths[parent->second] : 0));
      reaches.push_back(way + (is_held ? reaches[parent->second] : 0));
      depth_ = std::max(depth_, depths.back());
      hold_of_.emplace(hold.child, model_.holds.size());
      model_.holds.push_back(
          FloatOf(hold, is_held ? static_cast<std::int32_t>(parent->second) : -1, outer));
    }
    reaches_ = std::move(reaches);
  }

  void AddLinks() {
    std::size_t offset = 0;
    for (const BallModel::Link& link : balls_.links) {
      const std::size_t hold = hold_of_.at(link.object);
      LaneModel::Link to = {hold, offset, FloatOf(link.bound), {}, {}, {}};
      for (const Ball& ball : link.balls) to.balls.push_back(FloatOf(ball));
      offset += 1 + link.balls.size();
      reach_ = std::max(reach_, reaches_[hold] + link.bound.centre.norm() + link.bound.radius);
      model_.links.push_back(std::move(to));
    }
  }

  void Add(const Obstacle& obstacle) {
    LaneModel::FloatObstacle to = {};
    Put(obstacle.centre, to.centre);
    Put(obstacle.half, to.half);
    Put(Matrix3d(obstacle.axes.transpose()), to.axes);
    to.radius = static_cast<float>(obstacle.radius);
    to.disc = static_cast<float>(obstacle.disc);
    to.is_aligned = obstacle.axes == Matrix3d::Identity() || obstacle.half.isZero(0);
    extent_ = std::max(extent_, obstacle.centre.norm() + obstacle.half.norm() + obstacle.radius);
    model_.obstacles.push_back(to);
  }

  const plan::Scene& scene_;
  const layouts::InitialState& state_;
  const KinematicTree& tree_;
  const BallModel& balls_;
  LaneModel model_;
  std::map<std::size_t, std::size_t> hold_of_;  ///< by object
  std::vector<double> reaches_;
  std::size_t depth_ = 0;
  double reach_ = 0, extent_ = 0;
};

const LaneKernel& FastestKernel() {
  return Avx2LaneKernel() != nullptr ? *Avx2LaneKernel() : PlainLaneKernel();
}

}  // namespace

const LaneKernel& PlainLaneKernel() {
  static constexpr LaneKernel kKernel = {kFloats, CheckLanes};
  return kKernel;
}

std::size_t RoomOf(const LaneModel& model, std::size_t lanes) {
  std::size_t vectors = 4 * model.holds.size();
  for (const LaneModel::Link& link : model.links) vectors += 1 + link.balls.size();
  return 3 * lanes * vectors;
}

LaneChecker::LaneChecker(const plan::Scene& scene, const layouts::InitialState& state,
                         const LaneKernel* kernel)
    : state_(state),
      tree_(scene, state),
      balls_(BallModelOf(scene, state, tree_)),
      model_(ModelMaker(scene, state, tree_, balls_).Make()),
      kernel_(kernel != nullptr ? *kernel : FastestKernel()),
      room_(RoomOf(model_, kernel_.lanes)) {
  const std::vector<analysis::Freedom> freedoms = analysis::FreedomsOf(scene);
  for (const analysis::Freedom& freedom : freedoms) {
    const bool is_bounded = !freedom.is_slider || std::isfinite(freedom.lower);
    lower_.push_back(freedom.is_slider ? (is_bounded ? freedom.lower : 1) : -kMostTurn);
    upper_.push_back(freedom.is_slider ? (is_bounded ? freedom.upper : 0) : kMostTurn);
  }
}

std::size_t LaneChecker::lanes() const { return kernel_.lanes; }

bool LaneChecker::IsInReach(std::span<const double> positions) const {
  for (std::size_t i = 0; i < positions.size(); ++i)
    if (!(positions[i] >= lower_[i] && positions[i] <= upper_[i])) return false;
  return true;
}

bool LaneChecker::Recheck(std::span<const double> positions) {
  ++rechecked_;
  tree_.PosesAt(positions, poses_);
  return HitsInDouble(balls_, state_.objects, poses_);
}

void LaneChecker::Check(std::span<const double> positions, std::span<std::uint8_t> hits) {
  const std::size_t freedoms = tree_.freedoms(), count = hits.size(), lanes = kernel_.lanes;
  CDB_CHECK(positions.size() == count * freedoms);
  std::vector<double> last;  // the rest, filled up
  for (std::size_t first = 0; first < count; first += lanes) {
    const double* these = positions.data() + first * freedoms;
    const std::size_t rest = std::min(lanes, count - first);
    if (rest < lanes) {
      last.assign(these, these + rest * freedoms);
      while (last.size() < lanes * freedoms) last.push_back(last[last.size() - freedoms]);
      these = last.data();
    }
    const LaneKernel::Answer answer = kernel_.check(model_, these, room_.data());
    for (std::size_t i = 0; i < rest; ++i) {
      const std::span<const double> here = positions.subspan((first + i) * freedoms, freedoms);
      const bool is_sure = (answer.doubts >> i & 1) == 0 && IsInReach(here);
      hits[first + i] = is_sure ? (answer.hits >> i & 1) : Recheck(here);
    }
  }
}

}  // namespace cdb::robots
