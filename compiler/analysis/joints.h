// Joints between the objects of two groups: what their settings mean, and which cannot be.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "compiler/plan/plan.h"

namespace cdb::analysis {

/// For messages: `the joint elbow`.
std::string TextOf(const plan::Joint& joint);
bool HasLimits(const plan::Joint& joint);
/// Whether a motor seeks a velocity or a position; or gives a torque, or a force.
bool HasMotor(const plan::Joint& joint);
bool HasTorqueMotor(const plan::Joint& joint);
/// Whether a joint that holds objects joins the group to another, or to the world.
bool IsJoined(const plan::Scene& scene, std::string_view group);
/// The first joint that holds objects and has such a motor; null if there is none. Likewise for
/// limits or damping, which take energy.
const plan::Joint* FindMotor(const plan::Scene& scene);
const plan::Joint* FindTorqueMotor(const plan::Scene& scene);
const plan::Joint* FindLosses(const plan::Scene& scene);

/// A coupling: the position of a joint is `ratio` times that of the joint `with`, plus `offset`.
struct Gear {
  const plan::Joint* with;
  double ratio, offset;
};
/// The gear of a joint of the scene; nullopt if it has none, or one with a JointFault, or holds no
/// objects. Gears end in a joint without one.
std::optional<Gear> GearOf(const plan::Scene& scene, const plan::Joint& joint);
bool HasGears(const plan::Scene& scene);

struct JointFault {
  enum class Kind { kContradiction, kQuantity, kUnknownGroup };
  schema::GroupParameter parameter;  ///< whose value is at fault
  std::string message;               ///< kUnknownGroup: the name
  std::string help = {};
  Kind kind = Kind::kContradiction;
};

/// The reason why this joint of the scene cannot be made; nullopt if it can.
std::optional<JointFault> FindJointFault(const plan::Scene& scene, const plan::Joint& joint);

/// Why Bullet's articulated bodies cannot have the joints of a scene.
struct ReducedFault {
  std::string group;                   ///< whose parameter it is; empty for the world's
  const schema::Parameter* parameter;  ///< whose value is at fault
  std::string message, help;
};

/// The first reason why a scene cannot have `coordinates reduced`; nullopt if it can, or does not.
std::optional<ReducedFault> FindReducedFault(const plan::Scene& scene);

}  // namespace cdb::analysis
