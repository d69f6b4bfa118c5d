#include "compiler/scenario/layers.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "compiler/analysis/pruning.h"
#include "compiler/scenario/diagnostic_kinds.h"
#include "compiler/schema/language_words.h"
#include "compiler/schema/value.h"

namespace cdb::scenario {
namespace {

constexpr std::string_view kUnnamedGroup = "objects";
using schema::kJointsBlock;
using schema::NamedBlockOf;
/// Finding similar names dominates the cost of an error, and nobody reads more than this.
constexpr int kMostSuggestions = 1000;

bool HasBlock(std::string_view outer, bool grouped, std::string_view name) {
  const auto blocks = schema::BlocksIn(outer, grouped);
  return std::ranges::find(blocks, name) != blocks.end();
}

/// Parameters whose words may be names of lets, as scenarios had such lets before.
bool LeavesItsWords(const schema::Parameter& parameter) {
  return parameter.NamedBlock() == schema::kQueriesBlock ||
         parameter.name.starts_with("configurations.") || parameter.name.ends_with("coordinates");
}

/// True for names that a let must not have. Names of components, errors and closed forms are
/// allowed, and those that only queries or configurations take: `gravity`, `distance`, `spin` and
/// `side` are useful names in a scene, and after the parameter that takes them they are words
/// (Names::Resolve).
bool IsWordOfTheLanguage(std::string_view name, std::span<const schema::PluginDetector> plugins) {
  const bool is_reserved_distribution =
      name == "uniform" || name == "normal" || name == "log_uniform" || name == "any";
  if (is_reserved_distribution || name == "sweep" || name == "true" || name == "false" ||
      name == "on" || name == "off")
    return true;
  return std::ranges::any_of(schema::Schema(), [&](const schema::Parameter& p) {
    if (LeavesItsWords(p)) return false;
    const bool is_shared = p.word_source == schema::WordSource::kComponents ||
                           p.word_source == schema::WordSource::kMetrics ||
                           p.word_source == schema::WordSource::kClosedForms;
    return p.HasWord(name, plugins) && !(is_shared && !schema::ListsWord(p.words, name));
  });
}

/// The name of a parameter as written in a block; empty if it cannot be set there.
std::string NameIn(const schema::Parameter& parameter, const std::string& block, bool in_group) {
  if (in_group && parameter.NamedBlock() != NamedBlockOf(block)) return {};
  if (parameter.grouped && !in_group) return block.empty() ? parameter.FullName() : std::string();
  if (parameter.grouped != in_group) return {};
  const std::string name(parameter.name);
  if (block.empty()) return name;
  return name.starts_with(block + ".") ? name.substr(block.size() + 1) : std::string();
}

/// A parameter that can be set in a block, or null.
const schema::Parameter* FindIn(const std::string& block, bool in_group, std::string_view name) {
  const schema::Parameter* parameter = schema::FindParameter(Joined(block, name), in_group);
  // In `objects { joints { } }`, there is none.
  return parameter != nullptr && parameter->NamedBlock() != NamedBlockOf(block) ? nullptr
                                                                                : parameter;
}

/// The kinds of blocks that may have names: `objects`, and those of schema::kNamedBlocks.
bool IsNamedKind(std::string_view kind) {
  return kind == kUnnamedGroup || (!kind.empty() && NamedBlockOf(kind) == kind);
}

/// One block of the kind, for messages; `block` as in DeclareGroup.
std::string_view OneOf(std::string_view block) {
  return block == kJointsBlock ? "joint" : block.empty() ? "group" : block;
}

/// A place for messages: `pebbles.links`; `elbow.motor`, of a joint.
std::string NameOf(const std::string& group, std::string_view block) {
  if (const std::string_view named = NamedBlockOf(block); !named.empty())
    block.remove_prefix(std::min(block.size(), named.size() + 1));
  return Joined(group, block);
}

/// A suggestion for an unknown name: the correction of a typing error, or the equivalent of a name
/// from elsewhere.
std::string SuggestParameter(std::string_view word, const std::string& block, bool in_group) {
  std::vector<std::string> names;
  for (const schema::Parameter& parameter : schema::Schema()) {
    const std::string name = NameIn(parameter, block, in_group);
    if (name.ends_with(fmt::format(".{}", word))) return fmt::format("did you mean '{}'?", name);
  }
  for (const schema::Parameter& parameter : schema::Schema()) {
    const std::string name = NameIn(parameter, block, in_group);
    if (name.empty()) continue;
    if (schema::ListsWord(parameter.also, word))
      return fmt::format("did you mean '{}', {}?", name,
                         parameter.doc.substr(0, parameter.doc.find(';')));
    names.push_back(name);
  }
  const std::string_view near = dsl::DidYouMean(word, {names.begin(), names.end()});
  if (!near.empty()) return fmt::format("did you mean '{}'?", near);
  for (const schema::Parameter& parameter : schema::Schema())
    if (schema::ListsWord(parameter.also, word))
      return fmt::format("did you mean '{}', outside this block?", parameter.FullName());
  return "`cdb doc parameters` lists them";
}

}  // namespace

LayeredBenchmark::LayeredBenchmark(const Scenario& scenario, const BenchmarkRef& benchmark,
                                   dsl::Diagnostics& diagnostics)
    : scenario_(scenario), diagnostics_(diagnostics) {
  Chain(benchmark);
  if (!scenario.is_complete()) damage_ = dsl::Damage::kLost;
  for (const BenchmarkRef& layer : chain_) damage_ = std::max(damage_, layer.benchmark->damage);
  if (!is_readable()) return;
  for (const BenchmarkRef& layer : chain_) CollectLabels(layer.benchmark->block);
  ExpandRobots();
  for (const BenchmarkRef& layer : chain_) {
    Place place;
    place.file = layer.file;
    place.layer = layers_++;
    Walk(layer.benchmark->block, place);
  }
}

void LayeredBenchmark::Chain(const BenchmarkRef& benchmark) {
  std::set<const dsl::Benchmark*> seen;
  for (BenchmarkRef current = benchmark;;) {
    chain_.push_back(current);
    seen.insert(current.benchmark);
    if (!current.benchmark->from) break;
    const dsl::Name& from = *current.benchmark->from;
    // It may extend one of its own name in a file that it uses.
    auto base = scenario_.FindBenchmark(*current.file, from.text, current.benchmark);
    if (!base) base = scenario_.FindBenchmark(*current.file, from.text);
    if (!base || seen.contains(base->benchmark)) {
      has_base_ = false;
      ReportBase(from, *current.file, base.has_value());
      break;
    }
    current = *base;
  }
  std::ranges::reverse(chain_);
}

void LayeredBenchmark::ReportBase(const dsl::Name& from, const ScenarioFile& file, bool is_circle) {
  if (is_circle) {
    diagnostics_.Report(kCircular, from.span, fmt::format("'{}' refers to itself", from.text),
                        "a benchmark cannot extend one that extends it");
  } else if (scenario_.is_complete()) {
    const std::string_view near = dsl::DidYouMean(from.text, scenario_.BenchmarkNames(file));
    diagnostics_.Report(kUnknownName, from.span, fmt::format("no benchmark '{}'", from.text),
                        near.empty() ? "" : fmt::format("did you mean '{}'?", near));
  }
}

void LayeredBenchmark::CollectLabels(const dsl::Block& block) {
  for (const dsl::Statement& statement : block.statements) {
    if (const auto* group = std::get_if<dsl::Group>(&statement.what)) {
      if (!IsNamedKind(group->kind.text)) continue;
      const std::string_view named = NamedBlockOf(group->kind.text);
      if (group->label)
        LabelsOf(named).push_back(group->label->text);
      else if (named.empty())
        has_unnamed_block_ = true;
    } else if (const auto* cases = std::get_if<dsl::Cases>(&statement.what)) {
      for (const dsl::Case& one : cases->cases) CollectLabels(one.block);
    }
  }
}

void LayeredBenchmark::ExpandRobots() {
  std::vector<const dsl::Group*> found;
  const auto collect = [&](const dsl::Block& block, const auto& again) -> void {
    for (const dsl::Statement& statement : block.statements)
      if (const auto* group = std::get_if<dsl::Group>(&statement.what)) {
        if (group->kind.text == kRobotBlock) found.push_back(group);
      } else if (const auto* cases = std::get_if<dsl::Cases>(&statement.what)) {
        for (const dsl::Case& one : cases->cases) again(one.block, again);
      }
  };
  for (const BenchmarkRef& layer : chain_) collect(layer.benchmark->block, collect);
  const auto is_word = [&](const std::string& name) {
    return HasBlock("", false, name) || HasBlock("", true, name) ||
           schema::FindParameter(name, false) != nullptr || IsNamedKind(name) ||
           name == plan::kWorldWord || name == "walls" ||
           schema::FindLanguageWord(name) != nullptr ||
           IsWordOfTheLanguage(name, scenario_.plugins());
  };
  // Robots name the groups that they collide with, those of one another too.
  std::vector<std::string> labels = LabelsOf({});
  if (has_unnamed_block_) labels.emplace_back(kUnnamedGroup);
  std::map<const dsl::Group*, std::vector<std::string>> groups;
  dsl::Diagnostics later;
  for (const dsl::Group* robot : found)
    if (const auto blocks = ExpandRobot(scenario_, *robot, labels, is_word, later))
      groups[robot] = blocks->groups;
  for (const dsl::Group* robot : found) {
    std::vector<std::string> others = labels;
    for (const auto& [other, names] : groups)
      if (other != robot) others.insert(others.end(), names.begin(), names.end());
    if (auto blocks = ExpandRobot(scenario_, *robot, others, is_word, diagnostics_)) {
      const auto add = [this](std::string_view block, const std::vector<std::string>& names) {
        LabelsOf(block).insert(LabelsOf(block).end(), names.begin(), names.end());
      };
      add({}, blocks->groups);
      add(kJointsBlock, blocks->joints);
      robots_.emplace(robot, *std::move(blocks));
    } else {
      damage_ = std::max(damage_, dsl::Damage::kLost);
      lost_robots_ = true;
    }
  }
}

void LayeredBenchmark::WalkRobot(const dsl::Group& robot, const Place& place) {
  if (!place.group.empty() || !place.block.empty()) return ReportBlock(robot.kind, place);
  const auto found = robots_.find(&robot);
  if (found == robots_.end()) return;  // reported by ExpandRobots
  Place inner = place;
  inner.layer = layers_++;
  Walk(found->second.block, inner);
  for (const RobotBlocks::Given& given : found->second.given) {
    Entry entry;
    entry.case_axis = place.case_axis;
    entry.case_index = place.case_index;
    entry.key = {given.group, given.parameter};
    entry.setting = {
        given.setting,
        {place.file, given.group, std::string(given.parameter->NamedBlock()), given.parameter},
        order_};
    entries_.push_back(std::move(entry));
  }
}

void LayeredBenchmark::DeclareGroup(const std::string& name, std::string_view block,
                                    const Place& place) {
  groups_.push_back({name, block, place.case_axis, place.case_index});
}

void LayeredBenchmark::Once(const Place& place, const std::string& what, const text::Span& span,
                            const std::string& message) {
  const auto [first, is_new] =
      seen_.emplace(std::pair(place.layer, what), Seen{span, place.objects});
  if (is_new) return;
  const bool are_two = place.objects != nullptr && first->second.objects != nullptr &&
                       place.objects != first->second.objects;
  diagnostics_.Report(
      kSetTwice, span, message,
      are_two && place.group == kUnnamedGroup
          ? "two groups of objects need names: objects a { … } objects b { … }"
      : are_two && IsNamedKind(place.group)
          ? fmt::format("two {0} need names: {0} a {{ … }} {0} b {{ … }}", place.group)
          : "keep one of them",
      {{first->second.span, "it is here before"}});
}

void LayeredBenchmark::Walk(const dsl::Block& block, const Place& place) {
  for (const dsl::Statement& statement : block.statements) {
    ++order_;
    if (const auto* let = std::get_if<dsl::Let>(&statement.what)) {
      WalkLet(*let, place);
    } else if (const auto* cases = std::get_if<dsl::Cases>(&statement.what)) {
      WalkCases(*cases, place);
    } else if (const auto* group = std::get_if<dsl::Group>(&statement.what)) {
      WalkGroup(*group, place);
    } else if (const auto* setting = std::get_if<dsl::Setting>(&statement.what)) {
      WalkSetting(*setting, place);
    } else if (const auto* require = std::get_if<dsl::Require>(&statement.what)) {
      WalkRequire(*require, statement.span, place);
    } else if (const auto* skip = std::get_if<dsl::Skip>(&statement.what)) {
      Entry entry;
      entry.case_axis = place.case_axis;
      entry.case_index = place.case_index;
      entry.skip = {skip, {place.file, place.group, place.block, nullptr}, order_};
      entries_.push_back(std::move(entry));
    }
  }
}

void LayeredBenchmark::WalkLet(const dsl::Let& let, const Place& place) {
  if (IsWordOfTheLanguage(let.name.text, scenario_.plugins()))
    diagnostics_.Report(kReservedName, let.name.span,
                        fmt::format("'{}' is a word of the language", let.name.text),
                        "give the let another name");
  Once(place, "let " + Joined(place.group, place.block) + "." + let.name.text, let.name.span,
       fmt::format("there is already a let '{}'", let.name.text));
  Entry entry;
  entry.case_axis = place.case_axis;
  entry.case_index = place.case_index;
  entry.let = {&let, {place.file, place.group, place.block, nullptr}, order_};
  entries_.push_back(std::move(entry));
}

void LayeredBenchmark::WalkRequire(const dsl::Require& require, const text::Span& span,
                                   const Place& place) {
  if (place.case_axis >= 0 || !place.group.empty() || !place.block.empty())
    diagnostics_.Report(kWrongPlace, span, "a requirement is of the whole benchmark",
                        place.case_axis >= 0 ? "set it outside the cases; a value that differs "
                                               "between them needs a benchmark for each"
                                             : "set it outside this block");
  else
    requirements_.push_back({&require, {place.file, place.group, place.block, nullptr}, order_});
}

std::optional<std::string> LayeredBenchmark::KindBefore(const std::string& name,
                                                        std::string_view block) {
  if (block.empty()) return std::nullopt;
  if (std::ranges::find(LabelsOf({}), name) != LabelsOf({}).end()) return "group of objects";
  for (const std::string_view other : schema::kNamedBlocks) {
    if (other == block) return std::nullopt;
    if (std::ranges::find(LabelsOf(other), name) != LabelsOf(other).end())
      return std::string(OneOf(other));
  }
  return std::nullopt;
}

void LayeredBenchmark::EnterGroup(const dsl::Group& group, Place& place) {
  const std::string_view block = NamedBlockOf(group.kind.text);
  place.group = group.label ? group.label->text : group.kind.text;
  if (group.label) {
    const std::string remedy = fmt::format("give the {} another name", OneOf(block));
    if (HasBlock("", false, place.group) || HasBlock("", true, place.group) ||
        IsNamedKind(place.group) || schema::FindParameter(place.group, false) != nullptr)
      diagnostics_.Report(kReservedName, group.label->span,
                          fmt::format("'{}' is a word of the language", place.group), remedy);
    else if (const auto other = KindBefore(place.group, block))
      diagnostics_.Report(kSetTwice, group.label->span,
                          fmt::format("'{}' is also the name of a {}", place.group, *other),
                          remedy);
  }
  DeclareGroup(place.group, block, place);
  place.objects = &group;
  place.block = block;
}

void LayeredBenchmark::WalkGroup(const dsl::Group& group, const Place& place) {
  const std::string& kind = group.kind.text;
  if (kind == kRobotBlock) return WalkRobot(group, place);
  Place inner = place;
  if (IsNamedKind(kind) && place.group.empty() && place.block.empty()) {
    EnterGroup(group, inner);
  } else if (HasBlock(place.block, !place.group.empty(), kind)) {
    inner.block = Joined(place.block, kind);
    if (group.label)
      diagnostics_.Report(kWrongPlace, group.label->span, fmt::format("'{}' takes no name", kind),
                          "only objects, joints and queries have names");
  } else {
    ReportBlock(group.kind, place);
    return;
  }
  Walk(group.block, inner);
}

void LayeredBenchmark::ReportBlock(const dsl::Name& kind, const Place& place) {
  const bool in_group = !place.group.empty();
  const bool outermost = !in_group && place.block.empty();
  const std::string where = NameOf(place.group, place.block);
  const auto blocks = schema::BlocksIn(place.block, in_group);
  std::vector<std::string_view> kinds(blocks.begin(), blocks.end());
  if (outermost)
    kinds.insert(kinds.begin(), {kUnnamedGroup, kJointsBlock, kRobotBlock, schema::kQueriesBlock});
  const std::string_view near = dsl::DidYouMean(kind.text, kinds);
  if (outermost && HasBlock("", true, kind.text)) {
    diagnostics_.Report(kWrongPlace, kind.span,
                        fmt::format("'{}' is a block of objects", kind.text),
                        fmt::format("write objects {{ {} {{ … }} }}", kind.text));
  } else if (!outermost && (HasBlock("", false, kind.text) || IsNamedKind(kind.text) ||
                            kind.text == kRobotBlock)) {
    diagnostics_.Report(kWrongPlace, kind.span,
                        fmt::format("'{}' is not allowed inside '{}'", kind.text, where),
                        kind.text == kJointsBlock && in_group
                            ? "write it outside this block; within a group, each object is joined "
                              "to the next one by links { … }"
                            : "write it outside this block");
  } else if (kinds.empty()) {
    diagnostics_.Report(kWrongPlace, kind.span,
                        fmt::format("a block is not allowed inside '{}'", where));
  } else {
    diagnostics_.Report(
        kUnknownName, kind.span,
        fmt::format("no block{} is called '{}'", outermost ? "" : " of '" + where + "'", kind.text),
        near.empty()
            ? fmt::format("there {} {}{}", kinds.size() == 1 ? "is" : "are", fmt::join(kinds, ", "),
                          outermost ? fmt::format("; a group of objects with this name is "
                                                  "objects {} {{ … }}",
                                                  kind.text)
                                    : "")
            : fmt::format("did you mean '{}'?", near));
  }
}

void LayeredBenchmark::WalkCases(const dsl::Cases& cases, const Place& place) {
  if (place.case_axis >= 0) {
    diagnostics_.Report(kWrongPlace, cases.keyword, "cases are not allowed inside a case",
                        "write two `cases` side by side; the runs are their product");
    return;
  }
  CaseAxis axis;
  axis.name = cases.name ? cases.name->text : "case";
  axis.span = cases.name ? cases.name->span : cases.keyword;
  axis.order = order_;
  // Cases replace those of the same name in a base.
  auto index = std::ranges::find(case_axes_, axis.name, &CaseAxis::name) - case_axes_.begin();
  if (index < static_cast<std::ptrdiff_t>(case_axes_.size())) {
    Once(place, "cases " + axis.name, axis.span,
         fmt::format("there are already cases '{}'", axis.name));
    std::erase_if(entries_, [&](const Entry& entry) { return entry.case_axis == index; });
    std::erase_if(groups_, [&](const GroupDeclaration& g) { return g.case_axis == index; });
    axis.order = case_axes_[static_cast<std::size_t>(index)].order;
    case_axes_[static_cast<std::size_t>(index)] = axis;
  } else {
    Once(place, "cases " + axis.name, axis.span, {});
    case_axes_.push_back(axis);
  }
  if (cases.cases.empty() && is_complete())
    diagnostics_.Report(kNoRuns, cases.keyword, "it contains no case", "name { settings }");
  for (const dsl::Case& one : cases.cases) {
    auto& names = case_axes_[static_cast<std::size_t>(index)].names;
    Place inner = place;
    inner.case_axis = static_cast<int>(index);
    inner.case_index = names.size();
    inner.layer = layers_++;
    if (std::ranges::find(names, one.name.text) != names.end())
      diagnostics_.Report(kSetTwice, one.name.span,
                          fmt::format("there is already a case '{}'", one.name.text),
                          "give it another name");
    names.push_back(one.name.text);
    Walk(one.block, inner);
  }
}

bool LayeredBenchmark::IsLet(const std::string& name, const Place& place) const {
  return scenario_.FindLet(*place.file, name) ||
         std::ranges::any_of(entries_, [&](const Entry& entry) {
           return entry.let && entry.let->node->name.text == name;
         });
}

std::optional<ParameterKey> LayeredBenchmark::Resolve(const dsl::Name& path, const Place& place) {
  const std::string& text = path.text;
  const bool in_group = !place.group.empty();
  if (const schema::Parameter* parameter = FindIn(place.block, in_group, text))
    return {{place.group, parameter}};
  const auto misplaced = [&](const std::string& message, const std::string& hint) {
    diagnostics_.Report(kWrongPlace, path.span, message, hint);
    return std::nullopt;
  };
  if (in_group && schema::FindParameter(text, false) != nullptr)
    return misplaced(
        fmt::format("'{}' is a setting of the whole run, not of {}", text,
                    NamedBlockOf(place.block).empty() ? kUnnamedGroup : NamedBlockOf(place.block)),
        "write it outside this block");
  if (!place.block.empty() && FindIn("", in_group, text) != nullptr)
    return misplaced(
        fmt::format(
            "'{}' is not a setting of '{}'", text,
            NamedBlockOf(place.block).empty() ? place.block : NameOf(place.group, place.block)),
        NamedBlockOf(place.block).empty() ? "write it outside this block"
                                          : "it is a setting of objects");
  if (!in_group && place.block.empty()) {
    const std::size_t dot = text.find('.');
    const std::string head = text.substr(0, dot);
    const std::vector<std::string>& labels = LabelsOf({});
    const bool labelled = std::ranges::find(labels, head) != labels.end();
    const std::string own_name = dot == std::string::npos ? "" : text.substr(dot + 1);
    const schema::Parameter* of_group = own_name.empty() ? nullptr : FindIn("", true, own_name);
    for (const std::string_view block : schema::kNamedBlocks)
      if (head == block || std::ranges::find(LabelsOf(block), head) != LabelsOf(block).end())
        if (const auto* of_block = FindIn(std::string(block), true, own_name)) {
          DeclareGroup(head, block, place);
          return {{head, of_block}};
        }
    if (of_group != nullptr && (head == kUnnamedGroup || labelled)) {
      if (head == kUnnamedGroup && !labels.empty() && !has_unnamed_block_) {
        const std::string own = text.substr(dot);  // `.ccd`
        return misplaced(fmt::format("'{}' is outside of a group here", head),
                         fmt::format("write {}{}; or objects {{ … }} for further objects",
                                     fmt::join(labels, own + " or "), own));
      }
      DeclareGroup(head, {}, place);
      return {{head, of_group}};
    }
    if (of_group != nullptr && schema::FindParameter(text, false) == nullptr && !labels.empty())
      if (const auto near = dsl::DidYouMean(head, {labels.begin(), labels.end()}); !near.empty()) {
        diagnostics_.Report(kUnknownName, path.span, fmt::format("no group is called '{}'", head),
                            fmt::format("did you mean '{}'?", near));
        return std::nullopt;
      }
    if (FindIn("", true, text) != nullptr)
      return misplaced(fmt::format("'{}' is a setting of objects", text),
                       fmt::format("write objects.{}", text));
  }
  if (IsLet(text, place))
    return misplaced(fmt::format("'{}' is a let, not a parameter", text),
                     fmt::format("to change its value, write: let {} = …", text));
  // It may be of a link or a joint of a robot that could not be read.
  if (lost_robots_ && !in_group && place.block.empty() && text.find('.') != text.npos)
    return std::nullopt;
  const std::string where = NameOf(place.group, place.block);
  diagnostics_.Report(kUnknownName, path.span,
                      fmt::format("no parameter{} is called '{}'",
                                  where.empty() ? "" : " of '" + where + "'", text),
                      diagnostics_.error_count() < kMostSuggestions
                          ? SuggestParameter(text, place.block, in_group)
                          : "");
  return std::nullopt;
}

void LayeredBenchmark::WalkSetting(const dsl::Setting& setting, const Place& place) {
  const auto key = Resolve(setting.path, place);
  if (!key) return;
  Once(place, key->first + "/" + std::string(key->second->name), setting.path.span,
       fmt::format("'{}' is set twice", setting.path.text));
  Entry entry;
  entry.case_axis = place.case_axis;
  entry.case_index = place.case_index;
  entry.key = key;
  entry.setting = {&setting, {place.file, place.group, place.block, key->second}, order_};
  entries_.push_back(std::move(entry));
}

bool LayeredBenchmark::IsUnread(const Entry& entry) {
  if (entry.skip) return !entry.skip->node->when;
  const dsl::Expr& value = entry.let ? *entry.let->node->value : *entry.setting->node->values[0];
  return value.kind == dsl::ExprKind::kError;
}

Layers LayeredBenchmark::Lay(const std::vector<std::size_t>& chosen) const {
  Layers layers;
  layers.is_incomplete = !is_complete();
  layers.requirements = requirements_;
  layers.has_unread = layers.is_incomplete;
  for (const GroupDeclaration& group : groups_) {
    const bool stands = group.case_axis < 0 ||
                        chosen[static_cast<std::size_t>(group.case_axis)] == group.case_index;
    auto& names = layers.NamesOf(group.block);
    if (stands && std::ranges::find(names, group.name) == names.end()) names.push_back(group.name);
  }
  if (layers.groups.empty()) layers.groups.emplace_back(kUnnamedGroup);
  const auto lay = [&layers](const Entry& entry) {
    // A setting that overrides one of the base keeps that one's position in the order of axes; one
    // that a case overrides takes the position of the case.
    const auto put = [&entry](auto& map, const auto& key, const auto& placed) {
      auto& there = map.emplace(key, placed).first->second;
      const int order = entry.case_axis < 0 ? there.order : placed.order;
      there = placed;
      there.order = order;
    };
    layers.has_unread = layers.has_unread || IsUnread(entry);
    if (entry.setting) {
      put(layers.settings, *entry.key, *entry.setting);
    } else if (entry.let) {
      const Scope& scope = entry.let->scope;
      put(layers.lets, std::pair(Joined(scope.group, scope.block), entry.let->node->name.text),
          *entry.let);
    } else {
      layers.skips.push_back(*entry.skip);
    }
  };
  for (const Entry& entry : entries_)
    if (entry.case_axis < 0) lay(entry);
  for (const Entry& entry : entries_)
    if (entry.case_axis >= 0 &&
        chosen[static_cast<std::size_t>(entry.case_axis)] == entry.case_index)
      lay(entry);
  return layers;
}

}  // namespace cdb::scenario
