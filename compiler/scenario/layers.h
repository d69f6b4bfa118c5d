// A benchmark with its layers combined: its bases (`from`), its groups, and one choice of its
// cases.
#pragma once

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/scenario/robot_blocks.h"
#include "compiler/scenario/scenario.h"
#include "compiler/schema/schema.h"

namespace cdb::scenario {

/// The position of an expression, which determines the meaning of its names.
struct Scope {
  const ScenarioFile* file = nullptr;
  std::string group;  ///< of objects, a joint or queries; empty outside these
  std::string
      block;  ///< within the group or the benchmark: `world`, `accuracy.reference`; or empty
  /// The parameter being set; null in a let or a condition. Its own words take precedence over
  /// names of parameters: `omit sleeping` does not refer to the switch `sleeping`.
  const schema::Parameter* parameter = nullptr;
};

/// The name of `inner` outside the block or group `outer`: `pebbles.links`.
inline std::string Joined(std::string_view outer, std::string_view inner) {
  return std::string(outer) + (outer.empty() || inner.empty() ? "" : ".") + std::string(inner);
}
/// The block around `block`; empty if there is none.
inline std::string Outside(std::string_view block) {
  const std::size_t dot = block.rfind('.');
  return std::string(block.substr(0, dot == std::string_view::npos ? 0 : dot));
}

/// A parameter of the world (group empty), of a group, of a joint or of queries.
using ParameterKey = std::pair<std::string, const schema::Parameter*>;

/// A statement with its position in the order of writing.
template <typename Node>
struct Placed {
  const Node* node = nullptr;
  Scope scope;
  int order = 0;
};

/// The statements that make one run, after the choice of cases.
struct Layers {
  std::vector<std::string> groups, joints, queries;
  std::map<ParameterKey, Placed<dsl::Setting>> settings;
  std::map<std::pair<std::string, std::string>, Placed<dsl::Let>>
      lets;  ///< by group and block, and name
  std::vector<Placed<dsl::Skip>> skips;
  std::vector<Placed<dsl::Require>> requirements;  ///< the same for every choice of cases
  /// A value, or the condition of a skip, had a syntax error.
  bool has_unread = false;
  /// Statements had syntax errors, here or outside the benchmarks: one of them may define an
  /// unknown name.
  bool is_incomplete = false;

  /// The names of the blocks of schema::kNamedBlocks, or of the groups if `block` is empty.
  const std::vector<std::string>& NamesOf(std::string_view block) const {
    return block == schema::kJointsBlock    ? joints
           : block == schema::kQueriesBlock ? queries
                                            : groups;
  }
  std::vector<std::string>& NamesOf(std::string_view block) {
    return const_cast<std::vector<std::string>&>(std::as_const(*this).NamesOf(block));
  }
  /// The block of schema::kNamedBlocks that has this name; empty if none has.
  std::string_view NamedBlockWith(std::string_view name) const {
    for (const std::string_view block : schema::kNamedBlocks)
      if (std::ranges::find(NamesOf(block), name) != NamesOf(block).end()) return block;
    return {};
  }
};

/// `cases load { calm { … } storm { … } }`.
struct CaseAxis {
  std::string name;
  text::Span span;
  int order = 0;
  std::vector<std::string> names;
};

/// A benchmark and its bases, with names, places and duplicates checked once, then combined for
/// each choice of cases.
class LayeredBenchmark {
 public:
  LayeredBenchmark(const Scenario& scenario, const BenchmarkRef& benchmark,
                   dsl::Diagnostics& diagnostics);

  /// False if a base is missing or braces do not match: the settings are then unknown.
  bool is_readable() const { return has_base_ && damage_ != dsl::Damage::kMisnested; }
  /// True if no statement had a syntax error.
  bool is_complete() const { return damage_ == dsl::Damage::kNone; }
  const std::vector<CaseAxis>& case_axes() const { return case_axes_; }
  /// `chosen`: an index for each case axis.
  Layers Lay(const std::vector<std::size_t>& chosen) const;

 private:
  /// A statement, and the case that contains it (-1: none).
  struct Entry {
    int case_axis = -1;
    std::size_t case_index = 0;
    std::optional<ParameterKey> key;  ///< of a setting
    std::optional<Placed<dsl::Setting>> setting;
    std::optional<Placed<dsl::Let>> let;
    std::optional<Placed<dsl::Skip>> skip;
  };
  /// The current position: the layer (the statements of a benchmark, or one case) and the block.
  struct Place {
    const ScenarioFile* file = nullptr;
    std::string group, block;             ///< as in Scope
    const dsl::Group* objects = nullptr;  ///< the block of the group, joint or queries; or null
    int case_axis = -1;
    std::size_t case_index = 0;
    int layer = 0;
  };

  static bool IsUnread(const Entry& entry);
  void Chain(const BenchmarkRef& benchmark);
  /// Reports the reason why `from` gives nothing.
  void ReportBase(const dsl::Name& from, const ScenarioFile& file, bool is_circle);
  void CollectLabels(const dsl::Block& block);
  /// Finds what the robots of all layers stand for, and their labels.
  void ExpandRobots();
  void Walk(const dsl::Block& block, const Place& place);
  void WalkGroup(const dsl::Group& group, const Place& place);
  /// Enters `objects NAME { }`, `joints NAME { }` or `queries NAME { }`.
  void EnterGroup(const dsl::Group& group, Place& place);
  /// The kind of another block of this name, of those before `block` in the order of the schema.
  std::optional<std::string> KindBefore(const std::string& name, std::string_view block);
  /// Walks what the robot stands for as a layer below that of the place, which may override it.
  void WalkRobot(const dsl::Group& robot, const Place& place);
  void WalkCases(const dsl::Cases& cases, const Place& place);
  void WalkSetting(const dsl::Setting& setting, const Place& place);
  void WalkLet(const dsl::Let& let, const Place& place);
  void WalkRequire(const dsl::Require& require, const text::Span& span, const Place& place);
  bool IsLet(const std::string& name, const Place& place) const;
  std::optional<ParameterKey> Resolve(const dsl::Name& path, const Place& place);
  /// Reports the reason why there is no block of this name here.
  void ReportBlock(const dsl::Name& kind, const Place& place);
  /// `block`: of schema::kNamedBlocks; empty for a group of objects.
  void DeclareGroup(const std::string& name, std::string_view block, const Place& place);
  /// The labels of the blocks of this kind.
  std::vector<std::string>& LabelsOf(std::string_view block) { return labels_[block]; }
  void Once(const Place& place, const std::string& what, const text::Span& span,
            const std::string& message);

  const Scenario& scenario_;
  dsl::Diagnostics& diagnostics_;
  std::vector<BenchmarkRef> chain_;  ///< the base first
  struct GroupDeclaration {
    std::string name;
    std::string_view block;  ///< as in DeclareGroup
    int case_axis = -1;
    std::size_t case_index = 0;
  };
  std::map<std::string_view, std::vector<std::string>> labels_;  ///< by block, as in DeclareGroup
  bool has_unnamed_block_ = false;                               ///< `objects { … }`
  std::map<const dsl::Group*, RobotBlocks> robots_;
  bool lost_robots_ = false;  ///< one has errors
  std::vector<GroupDeclaration> groups_;
  std::vector<CaseAxis> case_axes_;
  std::vector<Entry> entries_;
  std::vector<Placed<dsl::Require>> requirements_;
  struct Seen {
    text::Span span;
    const dsl::Group* objects;  ///< as in Place
  };
  std::map<std::pair<int, std::string>, Seen> seen_;
  bool has_base_ = true;
  dsl::Damage damage_ = dsl::Damage::kNone;  ///< of the benchmark, its bases, and the files
  int order_ = 0;
  int layers_ = 0;
};

}  // namespace cdb::scenario
