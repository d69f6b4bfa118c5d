// A plan as YAML, run by run: of a run, only what differs from the one before is written anew.
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

/// The texts of one run after the other: only what differs from the last run is written anew. Not
/// for several threads.
class RunText {
 public:
  /// `indent`: before each line of an entry but the first.
  explicit RunText(std::string indent) : indent_(std::move(indent)) {}

  /// What follows is of this scene.
  void Set(const plan::Scene& scene);
  /// As RunId gives it.
  std::string Id(std::uint64_t rep) const;
  /// Appends the entry of the plan's `runs`; returns the id.
  std::string AppendYaml(const std::vector<std::size_t>& at, std::uint64_t rep,
                         std::string& out) const;
  /// As RunToYaml, without an indent. What follows is of its scene.
  std::string YamlOf(const plan::Run& run);

 private:
  /// A setting as it was written last.
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
  std::string yaml_;       ///< lines behind `rep`
};

/// Writes a plan in the order of its document: the head, skipped points, runs, the scenario's text.
/// Not for several threads.
class PlanWriter {
 public:
  /// `write` gets the text in pieces. Runs, skipped points and references of `head` are not read.
  PlanWriter(const plan::Plan& head, std::function<void(std::string_view)> write);

  void AddSkipped(const std::vector<std::size_t>& at);
  /// After all skipped points. Returns the run's id.
  std::string AddRun(const std::vector<std::size_t>& at, std::uint64_t rep,
                     const plan::Scene& scene);
  /// Once, after all runs.
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
