// A block `robot NAME { file "arm.urdf"; … }` as the blocks that it stands for: `objects` for each
// link and `joints` for each joint, which then are as if the user had written them.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/analysis/robot.h"
#include "compiler/schema/schema.h"
#include "dsl/diagnostics.h"
#include "dsl/syntax.h"

namespace cdb::scenario {

class Scenario;

inline constexpr std::string_view kRobotBlock = "robot";

/// A setting of the block itself. Others are those of objects: they are of each link, or of the
/// base.
struct RobotSetting {
  std::string_view name, takes, doc;
};
std::span<const RobotSetting> RobotSettings();

struct RobotBlocks {
  dsl::Block block;  ///< the blocks of links and joints
  /// A setting that the user wrote, and the group or joint that it belongs to.
  struct Given {
    const dsl::Setting* setting;
    std::string group;
    const schema::Parameter* parameter;
  };
  std::vector<Given> given;
  std::vector<std::string> groups, joints;  ///< their names
};

/// Nullopt after diagnostics. `others`: the other groups of the benchmark. `is_word`: whether a
/// name is a word of the language. The blocks refer to `robot`, which must outlive them.
std::optional<RobotBlocks> ExpandRobot(const Scenario& scenario, const dsl::Group& robot,
                                       const std::vector<std::string>& others,
                                       const std::function<bool(const std::string&)>& is_word,
                                       dsl::Diagnostics& diagnostics);

}  // namespace cdb::scenario
