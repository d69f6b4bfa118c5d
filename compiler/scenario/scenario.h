// A scenario file with all the files it uses, read and parsed.
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

#include "compiler/analysis/poses.h"
#include "compiler/analysis/trace.h"
#include "compiler/schema/plugins.h"
#include "dsl/diagnostics.h"
#include "dsl/syntax.h"

namespace cdb::scenario {

/// The disk, behind a function so that tests need none: the text of a file, or nullopt and why not.
using ReadFile =
    std::function<std::optional<std::string>(const std::string& path, std::string& why)>;

/// Looks into the bytes of a shared library, behind a function as well, and runs nothing of it: its
/// detectors with name, phases and limit, or nullopt and why there are none.
using DescribePlugin = std::function<std::optional<std::vector<schema::PluginDetector>>(
    const std::string& bytes, const std::string& path, std::string& why)>;

/// Shared libraries that a command line names, and how to look into any.
struct PluginSource {
  std::vector<std::string> files = {};
  DescribePlugin describe = {};
};

/// A parsed file and what its `use` lines reach.
struct ScenarioFile {
  std::string path;
  dsl::File tree;
  std::vector<const ScenarioFile*> uses;
  /// The first of each name.
  std::unordered_map<std::string_view, const dsl::Let*> lets;
  std::unordered_map<std::string_view, const dsl::Benchmark*> benchmarks;
};

/// A benchmark with the file whose names it sees.
struct BenchmarkRef {
  const ScenarioFile* file = nullptr;
  const dsl::Benchmark* benchmark = nullptr;
};

struct LetRef {
  const ScenarioFile* file = nullptr;
  const dsl::Let* let = nullptr;
};

/// All files of one compilation; owns the trees that everything else points into.
class Scenario {
 public:
  /// Reads `path` and what it uses: `use "other"` is looked for beside the file that says it, then
  /// in `library`, with or without `.cdb`; `use detector "mine.so"` likewise. Reports what cannot
  /// be read or parsed, a `use` that leads back to itself, a library that offers no detector, or
  /// one whose name is taken. What is wrong with a library of the command line has no place.
  Scenario(const std::string& path, const std::string& library, const ReadFile& read,
           const PluginSource& plugins, const analysis::ReadTrace& read_trace,
           const analysis::ReadPoses& read_poses, dsl::Diagnostics& diagnostics);

  /// Reports lets and benchmarks of one name in one file.
  void CheckNames(dsl::Diagnostics& diagnostics) const;

  /// Null where the file could not be read.
  const ScenarioFile* main() const { return main_; }
  /// False where a used file, or a statement outside the benchmarks, could not be read, so that
  /// names may be missing.
  bool is_complete() const { return is_complete_; }
  /// The file's own benchmarks, in order.
  std::vector<BenchmarkRef> Benchmarks() const;
  /// A benchmark, a file-level `let`, that `file` sees: its own, then those of the files it uses.
  std::optional<BenchmarkRef> FindBenchmark(const ScenarioFile& file, std::string_view name) const;
  std::optional<LetRef> FindLet(const ScenarioFile& file, std::string_view name) const;
  std::vector<std::string_view> BenchmarkNames(const ScenarioFile& file) const;
  std::vector<std::string_view> LetNames(const ScenarioFile& file) const;
  /// A file-level `let`'s place among all of them: used files first, as if their text stood where
  /// they are used.
  int LetOrder(const dsl::Let& let) const;
  /// The SHA-256 of a file, which is read once; nullopt, and why, where it cannot be read. Not for
  /// several threads.
  std::optional<std::string> HashOf(const std::string& path, std::string& why) const;
  /// The text of a file; nullopt, and why, where it cannot be read.
  std::optional<std::string> TextOf(const std::string& path, std::string& why) const {
    return read_(path, why);
  }
  /// The detectors of all plug-ins, whichever file uses them, in the order of their names.
  std::span<const schema::PluginDetector> plugins() const { return plugins_; }
  /// What a trace holds, read once; nullopt, and why, where it is of no use. Not for several
  /// threads.
  std::optional<analysis::TraceFacts> TraceAt(const std::string& path, std::string& why) const;
  /// What the table of a `poses` call holds, read once; nullopt, and why, where it is of no use.
  /// Not for several threads.
  std::optional<analysis::PoseFacts> PosesAt(const schema::Call& poses,
                                             analysis::PoseFault& why) const;
  /// The main file's text, then each used file's under a comment with its name.
  std::string FullText() const;

 private:
  const ScenarioFile* Load(const std::string& path, const dsl::Use* use,
                           dsl::Diagnostics& diagnostics);
  /// `wanted` as `path` says it: beside it, else in the library of scenarios; with `extension`.
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
};

}  // namespace cdb::scenario
