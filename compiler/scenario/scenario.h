// A scenario file and all files it uses, read and parsed.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "compiler/analysis/model.h"
#include "compiler/analysis/robot.h"
#include "compiler/analysis/trace.h"
#include "compiler/schema/catalogue.h"
#include "dsl/diagnostics.h"
#include "dsl/syntax.h"

namespace cdb::scenario {

/// Reads the text of a file, or gives nullopt and the reason; a function, so that tests need no
/// disk.
using ReadFile =
    std::function<std::optional<std::string>(const std::string& path, std::string& why)>;

/// Inspects the bytes of a shared library without running any of it: its detectors with name,
/// phases and limit, or nullopt and the reason why there are none. A function too.
using DescribePlugin = std::function<std::optional<std::vector<schema::PluginDetector>>(
    const std::string& bytes, const std::string& path, std::string& why)>;

/// The shared libraries of a command line, and the function that inspects any library.
struct PluginSource {
  std::vector<std::string> files = {};
  DescribePlugin describe = {};
};

/// A parsed file and the files of its `use` lines.
struct ScenarioFile {
  std::string path;
  dsl::File tree;
  std::vector<const ScenarioFile*> uses;
  /// The first let of each name.
  std::unordered_map<std::string_view, const dsl::Let*> lets;
  std::unordered_map<std::string_view, const dsl::Benchmark*> benchmarks;
};

/// A benchmark with its file, which determines the names it can use.
struct BenchmarkRef {
  const ScenarioFile* file = nullptr;
  const dsl::Benchmark* benchmark = nullptr;
};

struct LetRef {
  const ScenarioFile* file = nullptr;
  const dsl::Let* let = nullptr;
};

/// All files of one compilation; owns the syntax trees that all other data points into.
class Scenario {
 public:
  /// Reads `path` and the files it uses: `use "other"` is searched for in the folder of the file
  /// that contains it, then in `library`, with or without `.cdb`; likewise `use detector
  /// "mine.so"`. Reports files that cannot be read or parsed, cycles of `use`, a library without
  /// detectors, and a detector whose name is taken. Errors in a library of the command line have no
  /// location.
  Scenario(const std::string& path, const std::string& library, const ReadFile& read,
           const PluginSource& plugins, const analysis::ReadTrace& read_trace,
           const analysis::ReadPoses& read_poses, const analysis::ReadModel& read_model,
           const analysis::ReadRobot& read_robot, dsl::Diagnostics& diagnostics);

  /// Reports lets and benchmarks that share a name in one file.
  void CheckNames(dsl::Diagnostics& diagnostics) const;

  /// Null if the file could not be read.
  const ScenarioFile* main() const { return main_; }
  /// False if a used file, or a statement outside the benchmarks, had an error, so that names may
  /// be missing.
  bool is_complete() const { return is_complete_; }
  /// The file's own benchmarks, in order.
  std::vector<BenchmarkRef> Benchmarks() const;
  /// A benchmark or a file-level `let` visible in `file`: one of its own, then of the files it
  /// uses.
  std::optional<BenchmarkRef> FindBenchmark(const ScenarioFile& file, std::string_view name,
                                            const dsl::Benchmark* other_than = nullptr) const;
  std::optional<LetRef> FindLet(const ScenarioFile& file, std::string_view name) const;
  std::vector<std::string_view> BenchmarkNames(const ScenarioFile& file) const;
  std::vector<std::string_view> LetNames(const ScenarioFile& file) const;
  /// The position of a file-level `let` among all of them: used files first, as if their text
  /// replaced the `use` line.
  int LetOrder(const dsl::Let& let) const;
  /// The SHA-256 of a file, read once; nullopt and the reason if it cannot be read. Not
  /// thread-safe.
  std::optional<std::string> HashOf(const std::string& path, std::string& why) const;
  /// The text of a file; nullopt and the reason if it cannot be read.
  std::optional<std::string> TextOf(const std::string& path, std::string& why) const {
    return read_(path, why);
  }
  /// The detectors of all plug-ins, of all files, ordered by name.
  std::span<const schema::PluginDetector> plugins() const { return plugins_; }
  /// The facts about a trace, read once; nullopt and the reason if it cannot be used. Not
  /// thread-safe.
  std::optional<analysis::TraceFacts> TraceAt(const std::string& path, std::string& why) const;
  /// The facts about the table of a `poses` call, read once; nullopt and the reason if it cannot be
  /// used. Not thread-safe.
  std::optional<analysis::PoseFacts> PosesAt(const schema::Call& poses,
                                             analysis::PoseFault& why) const;
  /// The facts about a constant type of objects, read once; nullopt if they are unknown, and the
  /// reason if the type is no solid. Not thread-safe.
  std::optional<analysis::ModelFacts> ModelAt(const schema::Value& type,
                                              analysis::ModelFault& why) const;
  /// The robot of a file, read once; null and its faults if it cannot be used. Not thread-safe.
  std::shared_ptr<const analysis::Robot> RobotAt(const std::string& path,
                                                 const analysis::RobotOptions& options,
                                                 std::vector<analysis::RobotFault>& faults) const;
  /// The summaries of the robots read so far, and the notes on them.
  std::vector<std::string> RobotTexts() const;
  /// A line about a robot in a scene. Not thread-safe.
  void NoteOnRobot(std::string line) const;
  /// The texts about the models read so far, in the order of their types.
  std::vector<std::string> ModelTexts() const;
  /// The text of the main file, then of each used file under a comment with its name.
  std::string FullText() const;

 private:
  const ScenarioFile* Load(const std::string& path, const dsl::Use* use,
                           dsl::Diagnostics& diagnostics);
  /// Loads the files and plug-ins that `file` uses.
  void LoadUsed(ScenarioFile& file, dsl::Diagnostics& diagnostics);
  /// Finds `wanted` of the file `path`: beside it, else in the library of scenarios; with
  /// `extension`.
  std::string Find(const std::string& wanted, const std::string& path,
                   std::string_view extension) const;
  void LoadPlugin(const std::string& path, const dsl::Use* use, dsl::Diagnostics& diagnostics);
  void AddDetector(schema::PluginDetector detector, const dsl::Use* use,
                   dsl::Diagnostics& diagnostics);

  std::string library_;
  ReadFile read_;
  DescribePlugin describe_;
  std::vector<std::unique_ptr<ScenarioFile>> files_;
  std::vector<const ScenarioFile*> loading_;
  std::map<const dsl::Let*, int> let_order_;
  const ScenarioFile* main_ = nullptr;
  bool is_complete_ = true;
  struct FileHash {
    std::optional<std::string> sha256;
    std::string why;
  };
  mutable std::map<std::string, FileHash> hashes_;
  std::vector<schema::PluginDetector> plugins_;
  std::map<std::string, const dsl::Use*> plugin_files_;  ///< by path; null: the command line
  analysis::ReadTrace read_trace_;
  struct TraceRead {
    std::optional<analysis::TraceFacts> facts;
    std::string why;
  };
  mutable std::map<std::string, TraceRead> traces_;
  analysis::ReadPoses read_poses_;
  struct PosesRead {
    std::optional<analysis::PoseFacts> facts;
    analysis::PoseFault why;
  };
  mutable std::map<std::string, PosesRead> poses_;  ///< by the call without its hash
  analysis::ReadModel read_model_;
  struct ModelRead {
    std::optional<analysis::ModelFacts> facts;
    analysis::ModelFault why;
  };
  mutable std::map<std::string, ModelRead> models_;  ///< by the type as text
  analysis::ReadRobot read_robot_;
  struct RobotRead {
    std::string path;
    analysis::RobotOptions options;
    std::shared_ptr<const analysis::Robot> robot;
    std::vector<analysis::RobotFault> faults;
  };
  mutable std::vector<RobotRead> robots_;
  mutable std::vector<std::string> robot_notes_;
};

}  // namespace cdb::scenario
