// The columns of tables of poses and paths, whatever the format of the file: their names, units and
// frame.
//
// x, y, z (m); optionally qw, qx, qy, qz (unit quaternion) or rx, ry, rz (rad or deg, see the
// argument `rotation`); vx, vy, vz (m/s) and wx, wy, wz (rad/s) of poses; t (s) of a path. Errors:
// SceneError with the file, the line, the cause and the remedy. Threads: any.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/schema/value.h"
#include "dsl/text/units.h"
#include "library/layouts/pose_table.h"

namespace cdb::layouts {

inline constexpr std::size_t kPoseColumns = 17, kTimeColumn = 16;

/// A column that the argument `columns` names: `x=pos.x [mm]`.
struct NamedColumn {
  std::size_t column;   ///< its index in PoseColumns::values
  std::string written;  ///< `pos.x [mm]`
};
/// Those of a call `poses` or `path`, in the order written; empty if it names none.
std::vector<NamedColumn> NamedColumns(const schema::Call& call);

/// The numbers of a table, in SI units.
struct PoseColumns {
  std::array<bool, kPoseColumns> has = {};
  std::array<std::vector<double>, kPoseColumns> values;  ///< of the columns that it has
  std::size_t rows = 0;
  std::string name;                                   ///< of the file, or of its line of headings
  std::function<std::string(std::size_t row)> place;  ///< for messages: `start.csv:12`
};

/// Throws SceneError unless numbers of this unit can be in the column; `place` names the file.
void CheckUnit(std::size_t column, const std::optional<text::Unit>& unit, const std::string& name,
               const std::string& place);
/// The poses of the rows, turned and counted as the arguments `rotation`, `up` and `start` say.
PoseTable PosesOfColumns(const PoseColumns& columns, const schema::Call& call);

/// The poses of a text file.
PoseTable ParsePoseText(std::string_view text, const schema::Call& call);

}  // namespace cdb::layouts
