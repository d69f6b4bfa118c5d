// Checks many configurations of a robot of balls for collisions at a time, one in each lane of a
// SIMD register.
//
// Forward kinematics and distances are computed in single precision, with a bound of their error.
// A configuration in which two shapes are within this bound of touching is checked again in double,
// so that the answers are those of HitsInDouble, on every CPU. Configurations in which all are
// known to hit are left at once. Source of the idea: Thomason, Kingston, Kavraki, "Motions in
// microseconds via vectorized sampling-based planning", ICRA 2024.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "library/layouts/initial_state.h"
#include "library/robots/ball_model.h"
#include "library/robots/kinematic_tree.h"

namespace cdb::robots {

/// The model in single precision, and the forward kinematics as matrices.
struct LaneModel {
  /// A link at position x of its joint, in the frame of the link that holds it, or in the world:
  /// turned by turn[0] + cos x turn[1] + sin x turn[2], at way[0] + cos x way[1] + sin x way[2];
  /// of a slider, turn[0] at way[0] + x way[1]. Rows first.
  struct Hold {
    std::int32_t parent;   ///< index of a hold before this one; -1: the world
    std::int32_t freedom;  ///< -1: none
    bool is_slider;
    double start;
    float turn[3][9], way[3][3];
  };
  struct FloatBall {
    float centre[3];
    float radius;
  };
  struct Link {
    std::size_t hold;
    std::size_t offset;  ///< bounds and balls of the links before it
    FloatBall bound;
    std::vector<FloatBall> balls;
    std::vector<std::uint32_t> obstacles, links;  ///< that may touch; links with lower indices
  };
  struct FloatObstacle {
    float centre[3], half[3];
    float axes[9];  ///< columns of the axes, as rows
    float radius;
    float disc;       ///< of a cylinder about y; otherwise 0
    bool is_aligned;  ///< with the axes of the world
  };
  std::vector<Hold> holds;
  std::vector<Link> links;
  std::vector<FloatObstacle> obstacles;
  std::size_t freedoms = 0;
  /// m: distances are computed with a smaller error.
  float error = 0;
};

struct LaneKernel;

/// Not thread-safe: Check uses buffers. The state must outlive it.
class LaneChecker {
 public:
  /// Throws library::SceneError as BallModelOf does. `kernel`: null is the fastest one.
  LaneChecker(const plan::Scene& scene, const layouts::InitialState& state,
              const LaneKernel* kernel = nullptr);

  /// The number of configurations at a time.
  std::size_t lanes() const;
  const BallModel& balls() const { return balls_; }
  const KinematicTree& tree() const { return tree_; }
  const LaneModel& model() const { return model_; }
  /// How many configurations were checked again in double so far.
  std::uint64_t rechecked() const { return rechecked_; }

  /// `positions` are those of hits.size() configurations, one after the other; each hit becomes 1
  /// or 0.
  void Check(std::span<const double> positions, std::span<std::uint8_t> hits);

 private:
  /// False if the error of single precision is not known at these positions.
  bool IsInReach(std::span<const double> positions) const;
  bool Recheck(std::span<const double> positions);

  const layouts::InitialState& state_;
  const KinematicTree tree_;
  const BallModel balls_;
  LaneModel model_;
  const LaneKernel& kernel_;
  std::vector<float> room_;  ///< of the kernel
  std::vector<double> lower_, upper_;
  std::vector<objects::Pose> poses_;
  std::uint64_t rechecked_ = 0;
};

/// The kernel for one kind of CPU.
struct LaneKernel {
  std::size_t lanes;
  /// A bit for each of `lanes` configurations: that certainly hit, and that may hit.
  struct Answer {
    unsigned hits, doubts;
  };
  Answer (*check)(const LaneModel& model, const double* positions, float* room);
};
/// Floats that the kernel needs for a model.
std::size_t RoomOf(const LaneModel& model, std::size_t lanes);
/// For every CPU.
const LaneKernel& PlainLaneKernel();
/// Null if the CPU, or the build, lacks AVX2.
const LaneKernel* Avx2LaneKernel();

}  // namespace cdb::robots
