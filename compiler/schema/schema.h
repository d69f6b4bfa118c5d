// THE table of parameters. The checker, `did you mean`, `cdb doc`, the plan and the results read
// it; to add a parameter, add its row to parameter_table.h and the code that uses it.
#pragma once

#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/schema/catalogue.h"

namespace cdb::schema {

/// The values that a parameter takes, apart from its words.
enum class ParameterType {
  kCount,   ///< a whole number
  kReal,    ///< a number
  kSwitch,  ///< on, off, true, false
  kWord,    ///< one of `words`
  kWords,   ///< a list of `words`
  kVector,  ///< (x, y, z), or 0
  kRatio,   ///< 1 : y : z
  kText,    ///< "in quotes"
};

/// The source of a parameter's words, apart from its own row.
enum class WordSource {
  kOwn,
  kObjectTypes,
  kDetectors,     ///< those with a broad phase
  kNarrowPhases,  ///< the detectors with a narrow phase
  kLayouts,
  kComponents,
  kRecordWords,
  kMetrics,
  kClosedForms,
  kGroups,  ///< of the benchmark, and `walls`; known only within a scene
  kJoints,  ///< of the benchmark; known only within a scene
};
/// True if the words are known only within a scene.
constexpr bool AreNamesOfScene(WordSource source) {
  return source == WordSource::kGroups || source == WordSource::kJoints;
}

/// The numbers that a parameter takes: those between `min` and `max`. Applies to each component of
/// a vector and each part of a ratio.
struct Domain {
  double min = -std::numeric_limits<double>::infinity();
  bool min_open = false;  ///< `min` itself is excluded
  double max = std::numeric_limits<double>::infinity();
  bool not_zero = false;  ///< for a vector: (0, 0, 0) is excluded
  bool Contains(double value) const;
  /// `more than 0`, `0 or more`, `between 0 and 1`.
  std::string Text() const;
};

/// What a parameter determines.
enum class Concern {
  kScene,        ///< what is simulated
  kMethod,       ///< how it is simulated, and for how long
  kMeasurement,  ///< how a run is executed and measured, on the same scene
  kReport,       ///< what is asked of the results; in the head of a plan, and in no run
};

/// The blocks at the top level, other than `objects`, of which there may be several with names: the
/// rows `joints.type`, `queries.count` and so on are grouped, by block.
inline constexpr std::string_view kJointsBlock = "joints", kQueriesBlock = "queries";
inline constexpr std::string_view kNamedBlocks[] = {kJointsBlock, kQueriesBlock};
/// The one of these that `path` is, or is within; empty for the world and for objects.
constexpr std::string_view NamedBlockOf(std::string_view path) {
  for (const std::string_view block : kNamedBlocks)
    if (path == block || (path.starts_with(block) && path[block.size()] == '.')) return block;
  return {};
}

/// A row. Absence of a parameter from a plan means its first default, and ids of runs are hashes of
/// what differs from it. So a new row changes no plan and no id, and a row's `first_default` never
/// changes: another default goes into `later_default`, and plans then state it.
struct Parameter {
  /// Scenes that are made from the scene of a run.
  enum DerivedScene : unsigned {
    kPile = 1,       ///< brings the piles of the run to rest (compiler/yaml/plan_yaml.h)
    kReference = 2,  ///< the reference run (compiler/analysis/reference.h)
    kTrace = 4,      ///< the run on recorded boxes (compiler/checks/scene_checks.h)
    kDrop = 8,  ///< drops the objects of its piles, for many runs; ignores what kPile does, too
    kConfigurations = 16,  ///< checks configurations of joints (compiler/analysis/configurations.h)
  };

  std::string_view name = {};  ///< without its group: `world.side`; `size`
  bool grouped = false;        ///< one for each `objects` group, or for each block of NamedBlock
  ParameterType type = ParameterType::kReal;
  Domain domain = {};
  bool distribution = false;            ///< may be drawn (for each object; for the world, once)
  std::string_view unit = {};           ///< SI, empty if it has none
  std::string_view slider_unit = {};    ///< of a joint: the unit if its type is slider
  std::string_view first_default = {};  ///< as written in `.cdb`; see above
  std::string_view later_default = {};  ///< if it is no longer the first one
  std::string_view words = {};          ///< space-separated words it also takes
  WordSource word_source = WordSource::kOwn;
  std::string_view doc = {};    ///< one line
  std::string_view also = {};   ///< space-separated names often tried first, for suggestions
  std::string_view calls = {};  ///< space-separated words that take arguments: parametrised_words.h
  double number_of_word = 0;    ///< that a word stands for, if numbers are drawn: fixed is 0 kg
  Concern concern = Concern::kScene;
  unsigned ignored_by = kTrace;            ///< DerivedScenes in which it has its default instead
  bool closed_forms_need_default = false;  ///< other values: the scene has no closed form
  /// Of an argument that was added later: plans omit it at its default, so that they do not change.
  bool omitted_at_default = false;
  /// Of an argument that is a number: it takes a formula, whose variables are its words.
  bool is_formula = false;
  /// The parameter of the world whose value in the reference run this is, unless it is `same`.
  std::string_view of_reference = {};

  /// Within its group or block: `size`, `links.type`; `damping` of a joint.
  constexpr std::string_view OwnName() const {
    const std::string_view block = NamedBlock();
    return block.empty() ? name : name.substr(block.size() + 1);
  }
  /// `m`; `rad, or m of a slider`.
  std::string UnitText() const;
  /// As written in `.cdb`.
  std::string_view DefaultText() const {
    return later_default.empty() ? first_default : later_default;
  }
  /// `joints` of `joints.type`; empty if it belongs to the world or to a group of objects.
  constexpr std::string_view NamedBlock() const { return NamedBlockOf(name); }
  bool IsIgnoredBy(DerivedScene scene) const { return (ignored_by & scene) != 0; }
  /// `objects.size`, `timestep`.
  std::string FullName() const;
  /// Every word it takes, including those of the catalogue and of `plugins`.
  std::vector<std::string_view> AllWords(std::span<const PluginDetector> plugins = {}) const;
  bool HasWord(std::string_view word, std::span<const PluginDetector> plugins = {}) const;
  /// True if its words are detectors: whole ones, or narrow phases.
  bool TakesDetectors() const;
  std::vector<std::string_view> AllCalls() const;
  bool TakesCall(std::string_view word) const;
  /// True if its words with arguments are alternatives, as models are, and can be used in any( ). A
  /// schedule is not: it covers the whole run; density( ) takes the choices itself.
  bool ChoosesCalls() const { return type == ParameterType::kWord; }
  /// True if `word` concerns all other words of a list: it cannot be combined with another one,
  /// except with words that it does not cover.
  bool StandsAlone(std::string_view word) const;
  /// True if a list can hold `word`, which stands alone, and `other`: `omit auto, wall_pairs`.
  bool StandsBeside(std::string_view word, std::string_view other) const;
  /// `a length more than 0, or a distribution`: for messages and the reference. Words that need
  /// arguments are shown as `at( )`.
  std::string Takes(std::span<const PluginDetector> plugins = {}) const;
};

/// True if `word` is one of the space-separated `words`, as in the tables of schema and series.
bool ListsWord(std::string_view words, std::string_view word);

std::span<const Parameter> Schema();

/// The blocks that can be used in `block` (a path such as `accuracy`, or empty) and only shorten
/// names: `world`, `solver`; in a group of objects, those of the group; in `joints` and `queries`,
/// their own. They are the parts before the dots in the schema's names, in its order.
std::vector<std::string_view> BlocksIn(std::string_view block, bool grouped);

/// Looks up a name known only at run time; null if there is none. `name` is without its group. A
/// name in the code is a WorldParameter or a GroupParameter (parameter_ref.h).
const Parameter* FindParameter(std::string_view name, bool grouped);

}  // namespace cdb::schema
