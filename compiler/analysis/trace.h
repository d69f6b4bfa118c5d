// Facts about a trace, the recorded boxes named by `trace "run.trace.h5"`. Compiler and runner
// share them; the store reads traces.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "compiler/plan/plan.h"

namespace cdb::analysis {

struct TraceFacts {
  std::string sha256;        ///< of its boxes and filters, or of all of a mesh; 64 hex digits
  std::uint64_t bodies = 0;  ///< including walls
  std::uint64_t cycles = 0;
  double timestep_s = 0;
  bool is_double = false;  ///< recorded in double precision
  /// Of all that a narrow phase gets; empty if only boxes were recorded (`cdb trace` without
  /// --pairs).
  std::string pairs_sha256 = {};
  std::uint64_t pairs = 0;  ///< of all cycles
  /// Of a deforming mesh (library/deforming/primitives.h), whose bodies are these; else empty.
  std::string primitives = {};
  std::uint64_t vertices = 0;
};

/// Reads a trace from disk; a function, so that the compiler does not depend on HDF5. The facts
/// about `path`, or nullopt and the reason why it cannot be used.
using ReadTrace =
    std::function<std::optional<TraceFacts>(const std::string& path, std::string& why)>;

/// The trace on which the detector of a scene is run.
struct TraceName {
  std::string path, sha256;
  bool operator==(const TraceName&) const = default;
};
/// Nullopt if the scene runs in a live world.
std::optional<TraceName> TraceOf(const plan::Scene& scene);
/// True if the scene runs a narrow phase on the recorded pairs of its trace, and no broad phase.
bool IsOnPairs(const plan::Scene& scene);

// Facts about the table named by `location poses("start.csv")` or `location path("lift.csv")`.
// Compiler and library share them; the library reads tables (library/layouts/pose_table.h),
// the command line reads HDF5.

struct PoseFacts {
  /// 64 hex digits: of the file; for an HDF5 file, of the values read from it.
  std::string sha256;
  std::uint64_t count = 0;  ///< objects
  bool has_orientation = false, has_linear_velocity = false, has_angular_velocity = false;
  /// Of a path: the bounds of its positions, and the largest speed, m/s.
  Eigen::Vector3d least = Eigen::Vector3d::Zero(), most = Eigen::Vector3d::Zero();
  double fastest = 0;
  double first_time = 0, last_time = 0;  ///< s; of a path
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
/// The endings of tables of text.
inline constexpr std::string_view kTextFormats[] = {".csv", ".tsv", ".txt"};
/// True for CSV and other text, which a worker reads itself.
bool IsCsv(const schema::Call& poses);

// Objects whose type is a surface: triangles without an inside, which cannot move.

/// The word for a surface, as the type of a mesh; `heights` is a surface too.
inline constexpr std::string_view kSurfaceWord = "surface";

/// True if the type is a surface or a height field.
bool IsSurface(const schema::Call& type);
/// True if the group has objects, and all or some of them may be surfaces.
bool HasSurface(const plan::GroupSettings& settings);

}  // namespace cdb::analysis
