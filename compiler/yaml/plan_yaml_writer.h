// Writes a plan as YAML, run by run; only the differences to the previous run are formatted anew.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::yaml {

/// The texts of consecutive runs; only the differences to the last run are formatted anew. Not
/// thread-safe.
class RunText {
 public:
  /// `indent` precedes each line of an entry except the first.
  explicit RunText(std::string indent) : indent_(std::move(indent)) {}

  /// Selects the scene for the calls that follow.
  void Set(const plan::Scene& scene);
  /// The id, as from RunId.
  std::string Id(std::uint64_t rep) const;
  /// Appends the entry of the plan's `runs`; returns the id.
  std::string AppendYaml(const std::vector<std::size_t>& at, std::uint64_t rep,
                         std::string& out) const;
  /// As RunToYaml, without an indent. Selects the scene of `run`.
  std::string YamlOf(const plan::Run& run);

 private:
  /// A setting as last written.
  struct Line {
    std::string name;
    schema::Value value;
    std::string canonical, yaml;
  };
  using Lines = std::vector<Line>;
  struct GroupLines {
    std::string name, yaml;
    Lines lines;
  };

  /// `indent`: within the entry.
  bool Update(const plan::Settings& settings, std::string_view indent, Lines& lines) const;
  void Join(const plan::Scene& scene);

  std::string indent_;
  Lines world_;
  std::vector<GroupLines> groups_;
  plan::Role role_ = plan::Role::kMeasured;
  std::map<std::string, std::uint64_t, std::less<>> seeds_;
  std::vector<schema::PluginDetector> plugins_;
  bool is_begun_ = false;
  std::string canonical_;  ///< of the scene
  std::string yaml_;       ///< lines after `rep`
};

/// Writes the parts of a plan in the order of the document: the head, skipped points, runs, the
/// text of the scenario. Not thread-safe.
class PlanWriter {
 public:
  /// `write` receives the text in pieces. Runs, skipped points and references of `head` are
  /// ignored.
  PlanWriter(const plan::Plan& head, std::function<void(std::string_view)> write);

  void AddSkipped(const std::vector<std::size_t>& at);
  /// Call after all skipped points. Returns the id of the run.
  std::string AddRun(const std::vector<std::size_t>& at, std::uint64_t rep,
                     const plan::Scene& scene);
  /// Call once, after all runs.
  void Finish();

 private:
  void Flush(std::size_t more_than);
  void BeginRuns();

  const plan::Plan& head_;
  std::function<void(std::string_view)> write_;
  std::string buffer_;
  RunText text_{"    "};
  bool has_skipped_ = false, has_runs_ = false;
};

}  // namespace cdb::yaml
