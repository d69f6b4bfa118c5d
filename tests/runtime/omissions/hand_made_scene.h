// Scenes whose objects are placed by the test.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>

#include "library/layouts/initial_state.h"
#include "runtime/omissions/omissions.h"
#include "tests/support/scene.h"

namespace cdb::tests {

/// 60 cycles of 1/64 s in a cube of 100 m without gravity or sleep, in double precision, so that
/// times and positions are exact or nearly.
struct HandMade {
  HandMade() {
    Set("timestep", kStep);
    Set("cycles", std::uint64_t{60});
    Set("precision", Word("double"));
    Set("sleeping", false);
  }

  static constexpr double kStep = 1.0 / 64;

  void Set(schema::WorldParameter parameter, schema::Value value) {
    SetWorld(scene, parameter, std::move(value));
  }
  /// Adds a ball of radius 1 m and mass 1 kg; returns its index.
  std::size_t Add(const Eigen::Vector3d& place,
                  const Eigen::Vector3d& velocity = Eigen::Vector3d::Zero(), double mass = 1) {
    layouts::ObjectState& ball = state.objects.emplace_back();
    ball.solid.sides.setConstant(2);
    ball.pose.position = place;
    ball.linear_velocity = velocity;
    ball.mass = mass;
    return state.objects.size() - 1;
  }
  omissions::Reachability Make() const { return omissions::AnalyseReachability(scene, state); }

  plan::Scene scene = DefaultScene(1, 100);
  layouts::InitialState state;
};

/// The time of the last detection in a HandMade run, s.
inline constexpr double kLast = 59 * HandMade::kStep;
/// The distance from the middle of the cube to a wall, m.
inline constexpr double kHalf = 50;
/// Bullet's contact threshold for a ball of radius 1 m: 2 % of the bounding sphere of its bounding
/// cube.
inline const double kThreshold = 0.02 * std::sqrt(3.0);
/// The distance at touching from the centre of such a ball to a wall, and between the centres of
/// two.
inline const double kWallTouch = 1 + kThreshold;
inline const double kPairTouch = 2 + kThreshold;

/// The bit of a wall in `Reachability::walls`.
inline std::uint8_t Bit(int wall) { return static_cast<std::uint8_t>(1 << wall); }

}  // namespace cdb::tests
