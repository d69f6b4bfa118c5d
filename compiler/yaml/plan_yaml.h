// The plan as a YAML document: the output of `cdb plan -o` and the input of a worker.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::yaml {

/// The key of the format version, which identifies a plan.
inline constexpr std::string_view kPlanFormat = "cdb_plan";

/// The document is not a plan: the message gives file, line, error and remedy.
class PlanError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Only what differs from the defaults (plan::Settings). Reading the text back gives an equal plan:
/// reals are written so that they round-trip, seeds in hexadecimal.
std::string ToYaml(const plan::Plan& plan);

/// `name` is for messages. Formats from kOldestPlanVersion are read, and their ids kept
/// (Plan::Renew). Throws PlanError for a document of another one, a wrong type, an unknown
/// parameter, or a run whose id does not match its contents.
plan::Plan FromYaml(const std::string& text, const std::string& name);

/// The format of a plan, in either form, without reading all of it; nullopt for other texts.
std::optional<int> FindPlanVersion(std::string_view yaml);

/// A single run, as passed to a worker. Same form as an entry of the plan's `runs`.
std::string RunToYaml(const plan::Run& run);
plan::Run RunFromYaml(const std::string& text, const std::string& name);

// Writes a plan as YAML, run by run; only the differences to the previous run are formatted anew.

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
  /// `key`: before the name of each of `groups`, which have a name and settings.
  bool UpdateAll(const auto& groups, const char* key, std::vector<GroupLines>& lines) const;
  /// `kind`: before the name in the canonical text.
  void Append(std::string_view kind, const std::vector<GroupLines>& groups);
  void Join(const plan::Scene& scene);

  std::string indent_;
  Lines world_;
  std::vector<GroupLines> groups_, joints_, queries_;
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

// Identifies the runs of a sweep that begin with the same pile.

/// True if the group has objects and `location pile`.
bool HasPile(const plan::Group& group);
bool HasPile(const plan::Scene& scene);

/// The scene in which the objects of its piles drop: in double precision, with a fixed detector and
/// solver, recording nothing. What the drop ignores is at its default
/// (schema::Parameter::ignored_by).
plan::Scene DropScene(const plan::Scene& scene);

/// The scene in which its piles come to rest: with the precision, time step, solver and contact
/// settings of the run, but a fixed detector, and never asleep. Runs that are compared with a
/// reference, and the reference, all begin with the pile of SharesPile.
plan::Scene RestScene(const plan::Scene& scene);

/// True if other runs, with other values of the settings that a reference replaces, must begin with
/// the same pile. These settings have their defaults then, except for `precision double` and a time
/// step that depends on the objects.
bool SharesPile(const plan::Scene& scene);

/// Everything that determines the drop, and the piles, of a scene, as text: scenes with the same
/// text have the same piles.
std::string DropText(const plan::Scene& scene);
std::string PileText(const plan::Scene& scene);

}  // namespace cdb::yaml
