#include "compiler/schema/schema.h"

#include <algorithm>

#include "compiler/schema/catalogue.h"
#include "compiler/schema/components.h"
#include "compiler/schema/metrics.h"
#include "compiler/schema/parameter_table.h"
#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/series.h"
#include "compiler/schema/value.h"

namespace cdb::schema {
namespace {

using enum ParameterType;
using enum WordSource;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string_view NextWord(std::string_view& words) {
  const std::size_t space = words.find(' ');
  const std::string_view word = words.substr(0, space);
  words.remove_prefix(space == std::string_view::npos ? words.size() : space + 1);
  return word;
}

}  // namespace

bool Domain::Contains(double value) const {
  return (min_open ? value > min : value >= min) && value <= max;
}

std::string Domain::Text() const {
  const bool above = min != -kInfinity;
  const bool below = max != kInfinity && max < 2147483647;
  if (above && below && min_open)
    return "more than " + FormatReal(min) + " and at most " + FormatReal(max);
  if (above && below) return "between " + FormatReal(min) + " and " + FormatReal(max);
  if (above) return (min_open ? "more than " + FormatReal(min) : FormatReal(min) + " or more");
  return "any number";
}

std::string Parameter::FullName() const {
  return grouped && NamedBlock().empty() ? "objects." + std::string(name) : std::string(name);
}

std::string Parameter::UnitText() const {
  std::string text(unit);
  if (!slider_unit.empty()) text += ", or " + std::string(slider_unit) + " of a slider";
  return text;
}

std::vector<std::string_view> Parameter::AllWords(std::span<const PluginDetector> plugins) const {
  std::vector<std::string_view> all;
  for (std::string_view rest = words; !rest.empty();) all.push_back(NextWord(rest));
  const auto add = [&all](const auto& rows) {
    for (const auto& row : rows) all.push_back(row.name);
  };
  const auto add_detectors = [&](std::string_view phase) {
    for (const DetectorInfo& detector : Detectors())
      if (detector.HasPhase(phase)) all.push_back(detector.name);
    for (const PluginDetector& detector : plugins)
      if (FindDetector(detector.name, plugins)->HasPhase(phase)) all.push_back(detector.name);
  };
  switch (word_source) {
    case kOwn:
      break;
    case kObjectTypes:
      add(ObjectTypes());
      break;
    case kDetectors:
      add_detectors("broad");
      break;
    case kNarrowPhases:
      add_detectors("narrow");
      break;
    case kLayouts:
      add(Layouts());
      break;
    case WordSource::kRecordWords:
      add(schema::kRecordWords);
      break;
    case kComponents:
      add(Components());
      break;
    case kMetrics:
      add(Metrics());
      break;
    case kClosedForms:
      add(ClosedForms());
      break;
    case kGroups:
    case kJoints:
      break;
  }
  return all;
}

bool Parameter::HasWord(std::string_view word, std::span<const PluginDetector> plugins) const {
  const auto all = AllWords(plugins);
  return std::ranges::find(all, word) != all.end();
}

bool Parameter::TakesDetectors() const {
  return word_source == kDetectors || word_source == kNarrowPhases;
}

std::vector<std::string_view> Parameter::AllCalls() const {
  std::vector<std::string_view> all;
  for (std::string_view rest = calls; !rest.empty();) all.push_back(NextWord(rest));
  return all;
}

bool Parameter::TakesCall(std::string_view word) const { return ListsWord(calls, word); }

bool Parameter::StandsAlone(std::string_view word) const {
  return type == kWords && word_source != kOwn && ListsWord(words, word);
}

bool Parameter::StandsBeside(std::string_view word, std::string_view other) const {
  if (word_source != kComponents || word != "auto") return false;
  const ComponentInfo* component = FindComponent(other);
  return component != nullptr && !component->is_in_auto;
}

std::string Parameter::Takes(std::span<const PluginDetector> plugins) const {
  std::string text;
  switch (type) {
    case kCount:
      text = "a whole number, " + domain.Text();
      break;
    case kReal:
      text = "a number, " + domain.Text();
      break;
    case kSwitch:
      text = "on or off";
      break;
    case kWord:
      text = word_source == kGroups   ? "the name of a group"
             : word_source == kJoints ? "the name of a joint"
                                      : "one of";
      break;
    case kWords:
      text = "a list of";
      break;
    case kVector:
      text = domain.not_zero ? "a vector (x, y, z) other than 0" : "a vector (x, y, z), or 0";
      break;
    case kRatio:
      text = "a ratio 1 : y : z, each part " + domain.Text();
      break;
    case kText:
      text = "a text in quotes";
      break;
  }
  if (domain.min == -kInfinity && type == kReal) text = "a number";
  const bool only_words = (type == kWord && !AreNamesOfScene(word_source)) || type == kWords;
  std::string alone, listed;
  const auto list = [&](std::string_view word, std::string_view brackets) {
    listed += only_words ? (listed.empty() ? " " : ", ") : ", or ";
    listed += word;
    listed += brackets;
  };
  for (const std::string_view word : AllWords(plugins)) {
    if (StandsAlone(word)) {
      alone += std::string(word) + ", ";
    } else {
      list(word, "");
    }
  }
  for (const std::string_view call : AllCalls())
    list(call, RequiredArguments(*FindParametrisedWord(call)).empty() ? "" : "( )");
  if (word_source == kGroups && type == kWords) listed += " groups, and walls";
  if (word_source == kJoints && type == kWords) listed += " joints";
  text = (alone.empty() ? "" : alone + "or ") + text + listed;
  if (distribution) text += ", or a distribution";
  return text;
}

bool ListsWord(std::string_view words, std::string_view word) {
  while (!words.empty())
    if (NextWord(words) == word) return true;
  return false;
}

std::span<const Parameter> Schema() { return kParameters; }

std::vector<std::string_view> BlocksIn(std::string_view block, bool grouped) {
  std::vector<std::string_view> blocks;
  for (const Parameter& parameter : kParameters) {
    std::string_view rest = parameter.name;
    if (parameter.grouped != grouped) continue;
    if (block.empty() && !parameter.NamedBlock().empty()) continue;
    if (!block.empty()) {
      if (!rest.starts_with(std::string(block) + ".")) continue;
      rest.remove_prefix(block.size() + 1);
    }
    const std::size_t dot = rest.find('.');
    if (dot == std::string_view::npos) continue;
    const std::string_view name = rest.substr(0, dot);
    if (std::ranges::find(blocks, name) == blocks.end()) blocks.push_back(name);
  }
  return blocks;
}

const Parameter* FindParameter(std::string_view name, bool grouped) {
  const auto* row = std::ranges::find_if(kParameters, [&](const Parameter& parameter) {
    return parameter.grouped == grouped && parameter.name == name;
  });
  return row == kParameters.end() ? nullptr : row;
}

}  // namespace cdb::schema
