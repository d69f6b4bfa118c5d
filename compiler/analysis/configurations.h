// Configurations: positions of the joints of a robot that are checked for collisions one by one,
// instead of a motion that is simulated. A configuration takes the place of a cycle.
//
// The links of the robot are the objects that joints hold; all others are the scene, and fixed.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::analysis {

/// The stream of the positions that are drawn for the joint `elbow` is `elbow.positions`.
inline constexpr const char* kPositionStream = ".positions";

/// True if the scene is checked in configurations, and not simulated.
bool HasConfigurations(const plan::Scene& scene);
/// The call `list` if the positions come from a file; otherwise null.
const schema::Call* ConfigurationListOf(const plan::Scene& scene);

/// A hinge or a slider: one of the positions that make a configuration. rad or m.
struct Freedom {
  const plan::Joint* joint;
  bool is_slider;
  /// Its limits, and those of the joints in gear with it; of a hinge without any, half a turn to
  /// each side, of a slider without any, infinite.
  double lower, upper;
  bool has_limits;
  double start, goal;  ///< the ends of a path
  /// The freedom that it follows by gears, at `ratio` times its position plus `offset`.
  std::optional<std::size_t> driver = {};
  double ratio = 1, offset = 0;
};
/// In the order of the joints, without those that hold no objects. The scene must outlive them.
std::vector<Freedom> FreedomsOf(const plan::Scene& scene);
/// Sets the positions that follow others, of one configuration.
void Follow(std::span<const Freedom> freedoms, std::span<double> positions);

struct ConfigurationFault {
  std::string group;                   ///< or joint; empty for a parameter of the world
  const schema::Parameter* parameter;  ///< whose value is at fault
  std::string message, help;
};
/// The reason why the scene cannot be checked in configurations, which it asks for; nullopt if it
/// can. Its joints have no JointFault.
std::optional<ConfigurationFault> FindConfigurationFault(const plan::Scene& scene);

/// The rows of a list.
struct ConfigurationList {
  std::string sha256;             ///< of the file
  std::vector<double> positions;  ///< row by row, in the order of the freedoms
  std::size_t count = 0;          ///< of rows
};
/// `text` is that of its file, which has a column for each freedom, called as the joint. Throws
/// plan::TableError.
ConfigurationList ReadConfigurationList(const schema::Call& list, const std::string& text,
                                        const std::vector<Freedom>& freedoms);
/// The path of the file.
const std::string& FileOfList(const schema::Call& list);

}  // namespace cdb::analysis
