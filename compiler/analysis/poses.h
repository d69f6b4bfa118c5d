// Facts about the table named by `location poses("start.csv")` or `location path("lift.csv")`.
// Compiler and library share them; the library reads tables (library/layouts/pose_table.h, path.h),
// the command line reads HDF5.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "compiler/plan/plan.h"

namespace cdb::analysis {

struct PoseFacts {
  /// 64 hex digits: of the file; for an HDF5 file, of the values read from it.
  std::string sha256;
  std::uint64_t count = 0;  ///< objects
  bool has_orientation = false, has_linear_velocity = false, has_angular_velocity = false;
};

/// The reason why a table cannot be used.
struct PoseFault {
  bool is_unreadable = false;  ///< the file cannot be read at all
  std::string cause, remedy;   ///< `cause` names the file, and the line if there is one
};

/// Reads the facts from disk; a function, so that the compiler knows no file format. The call holds
/// a path, and its hash is not compared.
using ReadPoses = std::function<std::optional<PoseFacts>(const schema::Call& call, PoseFault& why)>;

/// The layout of the group if it is a table of poses, otherwise null.
const schema::Call* PosesOf(const plan::Group& group);
/// The layout of the group if it is the path of a kinematic object, otherwise null.
const schema::Call* PathOf(const plan::Group& group);
/// True for a CSV file, which a worker reads itself.
bool IsCsv(const schema::Call& poses);

}  // namespace cdb::analysis
