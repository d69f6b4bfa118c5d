// What is known of the table that `location poses("start.csv")` or `location path("lift.csv")`
// names. Compiler and library share it; reading one is the library's (library/layouts/pose_table.h,
// path.h), HDF5 the command line's.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "compiler/plan/plan.h"

namespace cdb::analysis {

struct PoseFacts {
  /// 64 hex digits: of the file; of an HDF5 file, of the values that are taken from it.
  std::string sha256;
  std::uint64_t count = 0;  ///< objects
  bool has_orientation = false, has_linear_velocity = false, has_angular_velocity = false;
};

/// Why a table is of no use.
struct PoseFault {
  bool is_unreadable = false;  ///< the file cannot be read at all
  std::string cause, remedy;   ///< `cause` names the file, and the line where there is one
};

/// The disk, behind a function so that the compiler knows no file format. The call's file is a path
/// and its hash is not compared.
using ReadPoses = std::function<std::optional<PoseFacts>(const schema::Call& call, PoseFault& why)>;

/// The group's layout, where it is a table of poses; null otherwise.
const schema::Call* PosesOf(const plan::Group& group);
/// The group's layout, where it is the path of a kinematic object; null otherwise.
const schema::Call* PathOf(const plan::Group& group);
/// The table is a CSV file, which a worker reads by itself.
bool IsCsv(const schema::Call& poses);

}  // namespace cdb::analysis
