// THE table of parameters. The checker, `did you mean`, `cdb doc`, the plan and the results read
// it; to add a parameter, add its row to parameter_table.h and the code that uses it.
#pragma once

#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/schema/plugins.h"

namespace cdb::schema {

/// What a parameter takes beside its words.
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

/// Where a parameter's words come from beside its own row.
enum class WordSource {
  kOwn,
  kObjectTypes,
  kDetectors,     ///< that have a broad phase
  kNarrowPhases,  ///< detectors that have one
  kLayouts,
  kComponents,
  kMetrics,
  kClosedForms,
  kGroups,  ///< of the benchmark, and `walls`; which there are is known only in a scene
};

/// Numbers a parameter takes: those between `min` and `max`. A vector's components each, a ratio's
/// parts each.
struct Domain {
  double min = -std::numeric_limits<double>::infinity();
  bool min_open = false;  ///< `min` itself is outside
  double max = std::numeric_limits<double>::infinity();
  bool not_zero = false;  ///< of a vector: (0, 0, 0) is outside
  bool Contains(double value) const;
  /// `more than 0`, `0 or more`, `between 0 and 1`.
  std::string Text() const;
};

struct Parameter {
  std::string_view name;  ///< without its group: `world.side`; `size`
  bool grouped = false;   ///< one for each `objects` group
  ParameterType type = ParameterType::kReal;
  Domain domain;
  bool distribution = false;      ///< may be drawn (for each object; for the world, once)
  std::string_view unit;          ///< SI, empty where it has none
  std::string_view default_text;  ///< as `.cdb` writes it
  std::string_view words;         ///< space-separated words it takes as well
  WordSource word_source = WordSource::kOwn;
  std::string_view doc;         ///< one line
  std::string_view also = {};   ///< space-separated names that people try first, to put them right
  std::string_view calls = {};  ///< space-separated words that take arguments: parametrised_words.h
  bool is_brief = false;        ///< a plan leaves it out where it has its default

  /// `objects.size`, `timestep`.
  std::string FullName() const;
  /// Every word it takes, those of the catalogue and of `plugins` included.
  std::vector<std::string_view> AllWords(std::span<const PluginDetector> plugins = {}) const;
  bool HasWord(std::string_view word, std::span<const PluginDetector> plugins = {}) const;
  /// Its words are detectors: whole ones, or narrow phases.
  bool TakesDetectors() const;
  std::vector<std::string_view> AllCalls() const;
  bool TakesCall(std::string_view word) const;
  /// Its words with arguments are things to choose from, as models are, and may stand in any( ). A
  /// schedule is not: it goes on for the whole run; density( ) takes the choices itself.
  bool ChoosesCalls() const { return type == ParameterType::kWord; }
  /// `word` speaks of all the others of a list: no list holds it and another, except those that it
  /// says nothing about.
  bool StandsAlone(std::string_view word) const;
  /// A list may hold `word`, which stands alone, and `other`: `omit auto, wall_pairs`.
  bool StandsBeside(std::string_view word, std::string_view other) const;
  /// `a length more than 0, or a distribution`: for messages and the reference. Words that need
  /// arguments are shown as `at( )`.
  std::string Takes(std::span<const PluginDetector> plugins = {}) const;
};

/// `word` is one of the space-separated `words`, as the tables of schema and series list them.
bool ListsWord(std::string_view words, std::string_view word);

std::span<const Parameter> Schema();

/// The blocks that may stand in `block` (a path such as `accuracy`, or empty) and do nothing but
/// shorten names: `world`, `solver`; in a group of objects those of its own. What the dots in the
/// schema's names say, in its order.
std::vector<std::string_view> BlocksIn(std::string_view block, bool grouped);

/// For a name that is known only at run time: null where there is none. `name` is without its
/// group. A name in the code is a WorldParameter or a GroupParameter (parameter_ref.h).
const Parameter* FindParameter(std::string_view name, bool grouped);

}  // namespace cdb::schema
