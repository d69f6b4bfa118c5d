#include "compiler/expand.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <tuple>
#include <utility>

#include "compiler/axes.h"
#include "compiler/capacity.h"
#include "compiler/convert.h"
#include "compiler/defaults.h"
#include "compiler/diagnostic_kinds.h"
#include "compiler/lints.h"
#include "compiler/needs.h"
#include "compiler/reference.h"
#include "compiler/traced_scene.h"
#include "dsl/check.h"

namespace cdb::compiler {
namespace {

using dsl::Expr;
using dsl::ExprKind;
using Point = std::vector<std::size_t>;

constexpr std::size_t kNowhere = static_cast<std::size_t>(-1);
/// What an axis holds in a case that has no value for it.
constexpr std::string_view kNoValue = "none";

/// Counts through all points of a grid, the last axis fastest. False at the end.
bool Advance(Point& point, const std::vector<std::size_t>& extents) {
  for (std::size_t i = extents.size(); i-- > 0;) {
    if (++point[i] < extents[i]) return true;
    point[i] = 0;
  }
  return false;
}

/// A constant argument as an expression gives it; nullopt for a distribution.
std::optional<Term> TermOf(const Value& value) {
  if (const auto* count = std::get_if<std::uint64_t>(&value))
    return Term{Number::Whole(static_cast<Integer>(*count))};
  if (const auto* real = std::get_if<double>(&value)) return Term{Number::Real(*real)};
  if (const auto* word = std::get_if<Word>(&value)) return Term{*word};
  if (const auto* text = std::get_if<Text>(&value)) return Term{*text};
  if (const auto* vector = std::get_if<Eigen::Vector3d>(&value)) return Term{*vector};
  return std::nullopt;
}

/// The argument that axis `like` sweeps, of a value that is not swept here; nullopt where that is
/// another word.
std::optional<Term> ArgumentLike(const SweepAxis& like, const Term& term) {
  std::optional<Call> call;
  if (term.call()) call = *term.call();
  if (term.word() && term.word()->text == like.word->name) call = WithDefaults(*like.word);
  if (!call || call->name != like.word->name) return std::nullopt;
  return TermOf(ArgumentOf(*call, like.argument->name));
}

/// The values of one parameter at the points of the axes on which it depends.
struct ParameterValues {
  ParameterKey key;
  std::vector<std::size_t> axes;  ///< of the configuration
  std::map<Point, Value> known;
  bool failed = false;
};

/// The benchmark under one choice of its cases.
class Configuration {
 public:
  Configuration(const Scenario& scenario, Layers layers, dsl::Diagnostics& diagnostics)
      : scenario_(scenario),
        layers_(std::move(layers)),
        evaluator_(scenario, layers_, diagnostics),
        axes_(FindAxes(layers_, evaluator_)) {
    // Also those that nothing uses: a file is checked whole.
    for (const auto& [key, let] : layers_.lets)
      if (let.node->value->kind != ExprKind::kRange)
        evaluator_.Evaluate(*let.node->value, let.scope);
    for (const Parameter& parameter : Schema()) {
      if (!parameter.grouped) {
        Add({"", &parameter});
        continue;
      }
      for (const std::string& group : layers_.groups) Add({group, &parameter});
    }
  }

  const Layers& layers() const { return layers_; }
  const std::vector<SweepAxis>& axes() const { return axes_; }
  Evaluator& evaluator() { return evaluator_; }

  void Choose(const Point& point) {
    for (std::size_t i = 0; i < axes_.size(); ++i) evaluator_.Choose(*axes_[i].call, point[i]);
    point_ = point;
  }

  /// All settings at the chosen point; nullopt after a diagnostic.
  std::optional<Scene> MakeScene() {
    Scene scene;
    for (const std::string& group : layers_.groups) scene.groups.push_back({group, {}});
    bool good = true;
    for (ParameterValues& values : parameters_) {
      const Value* value = Find(values);
      good = good && value != nullptr;
      if (value == nullptr) continue;
      Settings* settings = &scene.world;
      for (Group& group : scene.groups)
        if (group.name == values.key.first) settings = &group.settings;
      settings->values.emplace(std::string(values.key.second->name), *value);
    }
    if (!good) return std::nullopt;
    AddSeeds(scene);
    scene.plugins.assign(scenario_.plugins().begin(), scenario_.plugins().end());
    scene.KeepUsedPlugins();
    return scene;
  }

  /// Looks at every setting by itself.
  void CheckSettings() {
    Choose(Point(axes_.size(), 0));
    for (const ParameterValues& values : parameters_) ReportAll(values);
  }

  /// The place of a parameter's value at the chosen point, for diagnostics about it; the
  /// benchmark's name where it is a default.
  dsl::Span SpanOf(const ParameterKey& key, const dsl::Span& otherwise) {
    const auto setting = layers_.settings.find(key);
    if (setting == layers_.settings.end()) return otherwise;
    return evaluator_.Origin(*setting->second.node->values[0], setting->second.scope).span;
  }

  bool IsSet(const ParameterKey& key) const { return layers_.settings.contains(key); }

  /// The place of one word of the list that `key` is set to, at the chosen point.
  dsl::Span SpanOfWord(const ParameterKey& key, std::string_view word) {
    const Placed<dsl::Setting>& setting = layers_.settings.at(key);
    for (const auto& value : setting.node->values) {
      const auto term = evaluator_.Evaluate(*value, setting.scope);
      if (term && term->word() && term->word()->text == word)
        return evaluator_.Origin(*value, setting.scope).span;
    }
    CDB_CHECK(false);
  }

  /// The value that axis `like` of another configuration has here, where it is not swept.
  std::optional<Term> ConstantFor(const SweepAxis& like) {
    if (!like.key) return std::nullopt;
    const std::string& group = like.key->first;
    if (!group.empty() && std::ranges::find(layers_.groups, group) == layers_.groups.end())
      return std::nullopt;
    auto term = evaluator_.EvaluateParameter(*like.key);
    if (term && like.argument != nullptr) term = ArgumentLike(like, *term);
    if (!term || term->drawn()) return std::nullopt;
    if (like.component < 0) return term;
    const Eigen::Vector3d* parts = term->vector();
    if (const auto* ratio = std::get_if<Ratio>(&term->what)) parts = &ratio->parts;
    if (parts == nullptr) return std::nullopt;
    return Term{Number::Real((*parts)[like.component])};
  }

 private:
  void Add(const ParameterKey& key) {
    parameters_.push_back({key, Dependencies(key, layers_, axes_, evaluator_), {}, false});
  }

  const Value* Find(ParameterValues& values) {
    if (values.failed) return nullptr;
    Point at;
    for (const std::size_t axis : values.axes) at.push_back(point_[axis]);
    const auto known = values.known.find(at);
    if (known != values.known.end()) return &known->second;
    const auto value = Make(values.key);
    values.failed = !value;
    if (values.failed) ReportAll(values);
    return value ? &values.known.emplace(at, *value).first->second : nullptr;
  }

  /// Reports every value of a parameter that is no good, as far as a person would read on.
  void ReportAll(const ParameterValues& values) {
    constexpr int kMost = 1000;
    const Point here = point_;
    std::vector<std::size_t> extents;
    for (const std::size_t axis : values.axes) extents.push_back(axes_[axis].values.size());
    Point at(values.axes.size(), 0);
    for (int i = 0; i < kMost; ++i) {
      Point point = here;
      for (std::size_t a = 0; a < at.size(); ++a) point[values.axes[a]] = at[a];
      Choose(point);
      Make(values.key);
      if (!Advance(at, extents)) break;
    }
    Choose(here);
  }

  std::optional<Value> Make(const ParameterKey& key) {
    const Parameter& parameter = *key.second;
    const auto set = layers_.settings.find(key);
    const dsl::Setting& setting =
        set != layers_.settings.end() ? *set->second.node : DefaultSetting(parameter);
    const Scope scope = set != layers_.settings.end() ? set->second.scope : Scope{};
    if (parameter.type == ParameterType::kWords) {
      std::vector<std::pair<Term, dsl::Span>> terms;
      for (const auto& value : setting.values) {
        const auto term = evaluator_.Evaluate(*value, scope);
        if (!term) return std::nullopt;
        terms.emplace_back(*term, evaluator_.Origin(*value, scope).span);
      }
      return ConvertList(terms, parameter, evaluator_.diagnostics());
    }
    if (setting.values.size() > 1) {
      evaluator_.diagnostics().Report(
          kWrongKind, Join(setting.values.front()->span, setting.values.back()->span),
          fmt::format("'{}' takes one value, here are {}", parameter.name, setting.values.size()),
          "sweep(…) makes a run for each, any(…) draws one for each object");
      return std::nullopt;
    }
    const auto term = evaluator_.EvaluateParameter(key);
    if (!term) return std::nullopt;
    return evaluator_.ToValue(*term, parameter, *setting.values[0], scope);
  }

  static bool IsDrawn(const Value& value) {
    const auto* word = std::get_if<Word>(&value);
    const Call* call = AsCall(value);
    return std::holds_alternative<Distribution>(value) || (word && word->text == "random") ||
           (call && std::ranges::any_of(call->arguments, IsDrawn));
  }

  static void AddSeeds(Scene& scene) {
    const std::uint64_t seed = scene.world.Count("seed");
    const auto add = [&](const std::string& stream) {
      scene.seeds.emplace(stream, StreamSeed(seed, stream));
    };
    for (const auto& [name, value] : scene.world.values)
      if (IsDrawn(value)) add(name);
    for (const Group& group : scene.groups) {
      add(group.name + ".location");
      for (const auto& [name, value] : group.settings.values)
        if (IsDrawn(value)) add(group.name + "." + name);
    }
  }

  const Scenario& scenario_;
  Layers layers_;
  Evaluator evaluator_;
  std::vector<SweepAxis> axes_;
  std::vector<ParameterValues> parameters_;
  Point point_;
};

/// What a lint has to say about the runs of a benchmark.
struct LintFinding {
  LintNumber worst;
  dsl::Span span;  ///< of what makes the worst number
  std::size_t runs = 0, bad_runs = 0;
};

/// An axis of the plan: a sweep under one name in every configuration, or the names of cases.
struct GridAxis {
  Axis axis;
  std::pair<int, int> order;
  const SweepAxis* sweep = nullptr;  ///< one of those it was made from; null for cases
  std::size_t case_axis = kNowhere;
  std::vector<std::vector<Coordinate>> values;  ///< by configuration
};

class Expander {
 public:
  Expander(const Scenario& scenario, const BenchmarkRef& benchmark, dsl::Diagnostics& diagnostics,
           bool lints)
      : scenario_(scenario),
        benchmark_(benchmark),
        diagnostics_(diagnostics),
        lints_(lints),
        errors_before_(diagnostics.error_count()),
        layered_(scenario, benchmark, diagnostics) {}

  std::optional<Plan> Run() {
    if (!layered_.has_base() || !Configure()) return std::nullopt;
    MakeAxes();
    const bool countable = !Failed();
    if (!countable || !CountRuns()) {
      // No grid, but each setting can still be looked at.
      for (const auto& configuration : configurations_) configuration->CheckSettings();
      return std::nullopt;
    }
    MakeRuns();
    if (Failed() || broken_) return std::nullopt;
    AddReferences(plan_);
    if (plan_.runs.empty()) {
      diagnostics_.Report(kNoRuns, benchmark_.benchmark->name.span,
                          fmt::format("'{}' has no run left", benchmark_.benchmark->name.text),
                          "its `skip` leaves out every point");
      return std::nullopt;
    }
    ReportLints();
    return std::move(plan_);
  }

 private:
  bool Failed() const { return diagnostics_.error_count() > errors_before_; }

  bool TooMany(double count, const dsl::Span& span) {
    diagnostics_.Report(
        kTooManyRuns, span, fmt::format("this benchmark has {:.6g} runs", count),
        fmt::format("a plan holds at most {}; leave some out by `skip` or split the "
                    "benchmark",
                    kMaxRuns));
    return false;
  }

  bool Configure() {
    double count = 1;
    for (const CaseAxis& axis : layered_.case_axes()) {
      case_extents_.push_back(axis.names.size());
      count *= static_cast<double>(axis.names.size());
    }
    if (count > static_cast<double>(kMaxRuns))
      return TooMany(count, benchmark_.benchmark->name.span);
    Point chosen(case_extents_.size(), 0);
    do {
      configurations_.push_back(
          std::make_unique<Configuration>(scenario_, layered_.Lay(chosen), diagnostics_));
    } while (Advance(chosen, case_extents_));
    return true;
  }

  void MakeAxes() {
    for (std::size_t i = 0; i < layered_.case_axes().size(); ++i) {
      const CaseAxis& cases = layered_.case_axes()[i];
      GridAxis axis;
      axis.axis.name = cases.name;
      axis.axis.values.assign(cases.names.begin(), cases.names.end());
      axis.order = {cases.order, -1};
      axis.case_axis = i;
      grid_.push_back(std::move(axis));
    }
    for (const auto& configuration : configurations_)
      for (const SweepAxis& sweep : configuration->axes()) Merge(sweep);
    std::ranges::stable_sort(grid_, {}, &GridAxis::order);
    for (GridAxis& axis : grid_)
      if (axis.sweep != nullptr) FillValues(axis);
  }

  void Merge(const SweepAxis& sweep) {
    for (GridAxis& axis : grid_) {
      if (axis.axis.name != sweep.name) continue;
      if (axis.sweep == nullptr) {
        diagnostics_.Report(kAxisTwice, sweep.span,
                            fmt::format("there are cases called '{}' already", sweep.name),
                            fmt::format("name the axis: sweep(…) as {}_2", sweep.name));
      } else {
        axis.order = std::min(axis.order, sweep.order);
      }
      return;
    }
    GridAxis axis;
    axis.axis.name = sweep.name;
    axis.axis.parameter = sweep.parameter;
    axis.axis.unit = sweep.unit;
    axis.order = sweep.order;
    axis.sweep = &sweep;
    grid_.push_back(std::move(axis));
  }

  /// The axis holds every value that it has in some case; where it is not swept, the one that
  /// stands there.
  void FillValues(GridAxis& axis) {
    for (const auto& configuration : configurations_) {
      std::vector<Coordinate> here;
      const auto swept = std::ranges::find(configuration->axes(), axis.axis.name, &SweepAxis::name);
      if (swept != configuration->axes().end()) {
        here = swept->values;
      } else {
        const auto term = configuration->ConstantFor(*axis.sweep);
        if (!term) {
          here.emplace_back(std::string(kNoValue));
        } else if (term->number()) {
          here.emplace_back(term->number()->AsReal());
        } else {
          here.emplace_back(ToText(*term));
        }
      }
      axis.values.push_back(std::move(here));
    }
    bool text = false;
    for (const auto& here : axis.values)
      for (const Coordinate& value : here) text = text || value.index() == 1;
    for (auto& here : axis.values) {
      for (Coordinate& value : here) {
        if (text && value.index() == 0) value = FormatReal(std::get<double>(value));
        if (std::ranges::find(axis.axis.values, value) == axis.axis.values.end())
          axis.axis.values.push_back(value);
      }
    }
  }

  bool CountRuns() {
    double count = 1;
    for (const GridAxis& axis : grid_) {
      extents_.push_back(axis.axis.values.size());
      count *= static_cast<double>(axis.axis.values.size());
      plan_.axes.push_back(axis.axis);
    }
    const Parameter* repeats = FindParameter("repeats", false);
    std::optional<std::uint64_t> value;
    for (const auto& configuration : configurations_) {
      const dsl::Span span = configuration->SpanOf({"", repeats}, benchmark_.benchmark->name.span);
      Configuration& here = *configuration;
      if (!Dependencies({"", repeats}, here.layers(), here.axes(), here.evaluator()).empty()) {
        const dsl::Span whole = here.layers().settings.at({"", repeats}).node->values[0]->span;
        diagnostics_.Report(kMisplacedSweep, whole, "'repeats' cannot be swept",
                            "every point has as many: they are the axis `rep`");
        return false;
      }
      const auto term = here.evaluator().EvaluateParameter({"", repeats});
      const auto converted =
          term ? Convert(*term, *repeats, span, {}, {}, diagnostics_) : std::optional<Value>();
      if (!converted) return false;
      const std::uint64_t n = std::get<std::uint64_t>(*converted);
      if (value && *value != n) {
        diagnostics_.Report(kWrongPlace, span, "'repeats' is the same in every case",
                            "set it outside the cases");
        return false;
      }
      value = n;
    }
    plan_.repeats = *value;
    count *= static_cast<double>(*value);
    return count <= static_cast<double>(kMaxRuns) ||
           TooMany(count, benchmark_.benchmark->name.span);
  }

  void MakeRuns() {
    Point at(grid_.size(), 0);
    do {
      std::size_t chosen = 0;
      for (std::size_t i = 0; i < layered_.case_axes().size(); ++i)
        for (std::size_t a = 0; a < grid_.size(); ++a)
          if (grid_[a].case_axis == i) chosen = chosen * case_extents_[i] + at[a];
      if (!MakeRun(at, chosen)) plan_.skipped.push_back(at);
    } while (Advance(at, extents_));
  }

  /// False where the point is left out.
  bool MakeRun(const Point& at, std::size_t chosen) {
    Configuration& configuration = *configurations_[chosen];
    Point local(configuration.axes().size(), 0);
    for (std::size_t a = 0; a < grid_.size(); ++a) {
      if (grid_[a].sweep == nullptr) continue;
      const auto& here = grid_[a].values[chosen];
      const auto value = std::ranges::find(here, grid_[a].axis.values[at[a]]);
      if (value == here.end()) return false;
      const auto swept =
          std::ranges::find(configuration.axes(), grid_[a].axis.name, &SweepAxis::name);
      if (swept != configuration.axes().end())
        local[static_cast<std::size_t>(swept - configuration.axes().begin())] =
            static_cast<std::size_t>(value - here.begin());
    }
    configuration.Choose(local);
    if (IsSkipped(configuration, at)) return false;
    auto scene = configuration.MakeScene();
    const bool is_traced = scene && TraceOf(*scene);
    if (!scene || (is_traced && !Trace(configuration, *scene)) ||
        !CheckCounts(configuration, *scene) ||
        (!is_traced &&
         (!CheckNeeds(configuration, *scene) || !CheckAccuracy(configuration, *scene)))) {
      broken_ = true;
      return true;
    }
    if (lints_ && !is_traced) FindLints(configuration, *scene);
    for (std::uint64_t rep = 0; rep < plan_.repeats; ++rep)
      plan_.runs.push_back({RunId(*scene, rep), at, rep, *scene, {}, {}});
    return true;
  }

  /// Makes it a scene of its trace. False where what is set does not go with one.
  bool Trace(Configuration& configuration, Scene& scene) {
    std::string why;
    const auto facts = scenario_.TraceAt(TraceOf(scene)->path, why);
    CDB_CHECK(facts);
    const auto faults = LayTrace(configuration.layers(), *facts, scene);
    for (const TracedFault& fault : faults) {
      if (!untraceable_.emplace(fault.key, fault.word).second) continue;
      dsl::Span span = configuration.SpanOf(fault.key, benchmark_.benchmark->name.span);
      if (!fault.word.empty()) {
        span = configuration.SpanOfWord(fault.key, fault.word);
      } else if (fault.kind == &kContradiction) {
        span = configuration.layers().settings.at(fault.key).node->path.span;
      }
      diagnostics_.Report(*fault.kind, span, fault.message, fault.help);
    }
    return faults.empty();
  }

  bool IsSkipped(Configuration& configuration, const Point& at) {
    if (configuration.layers().skips.empty()) return false;
    Evaluator& evaluator = configuration.evaluator();
    for (std::size_t a = 0; a < grid_.size(); ++a) {
      const Axis& axis = grid_[a].axis;
      const Coordinate& value = axis.values[at[a]];
      Term term{Word{}};
      if (const auto* number = std::get_if<double>(&value)) {
        term = axis.IsInteger() ? Term{Number::Whole(static_cast<Integer>(*number))}
                                : Term{Number::Real(*number)};
      } else {
        term = Term{Word{std::get<std::string>(value)}};
        auto& words = evaluator.axis_words[axis.name];
        if (words.empty())
          for (const Coordinate& word : axis.values) words.push_back(std::get<std::string>(word));
      }
      evaluator.axis_values.insert_or_assign(axis.name, std::move(term));
    }
    bool skipped = false;
    for (const Placed<dsl::Skip>& skip : configuration.layers().skips)
      skipped = evaluator.Holds(*skip.node->when, skip.scope) || skipped;
    return skipped;
  }

  /// Limits that several parameters have together.
  bool CheckCounts(Configuration& configuration, const Scene& scene) {
    const dsl::Span name = benchmark_.benchmark->name.span;
    const std::uint64_t objects = scene.ObjectCount();
    const std::uint64_t bodies = BodyCount(scene);
    if (bodies > 2147483647) {
      diagnostics_.Report(kCapacity, name,
                          fmt::format("{} objects are more than a run holds", objects),
                          "2147483647 with the walls");
      return false;
    }
    const bool places_good = CheckPlaces(configuration, scene);
    if (!CheckLinks(configuration, scene) || !places_good) return false;
    bool holds = true;
    for (const char* parameter : {"detector", "narrow_phase"}) {
      const std::string_view word = scene.world.WordOr(parameter);
      const auto detector = FindDetector(word, scene.plugins);
      if (!detector || detector->Holds(bodies)) continue;
      holds = false;
      if (!std::exchange(capacity_reported_, true))
        diagnostics_.Report(
            kCapacity, configuration.SpanOf({"", FindParameter(parameter, false)}, name),
            fmt::format("'{}' holds at most {} bodies, walls included; here are {}", word,
                        detector->max_bodies, bodies),
            fmt::format("skip when quantity > {} and {} == {}, or use {}",
                        detector->max_bodies - (bodies - objects), parameter, word,
                        parameter == std::string_view("detector") ? "sap32" : "bullet"));
    }
    return holds;
  }

  /// `at` and `pair` place so many objects and no others.
  bool CheckPlaces(Configuration& configuration, const Scene& scene) {
    bool good = true;
    for (const Group& group : scene.groups) {
      const Call* location = AsCall(group.settings.Get("location"));
      const std::uint64_t quantity = group.settings.Count("quantity");
      const bool is_at = location != nullptr && location->name == "at";
      const bool is_pair = location != nullptr && location->name == "pair";
      if (!(is_at && quantity > 1) && !(is_pair && quantity != 2)) continue;
      good = false;
      if (!misplaced_.emplace(group.name, location->name).second) continue;
      diagnostics_.Report(
          kCapacity,
          configuration.SpanOf({group.name, FindParameter("location", true)},
                               benchmark_.benchmark->name.span),
          fmt::format("'{}' places {}, and the quantity of {} is {}", location->name,
                      is_at ? "one object" : "two objects", group.name, quantity),
          is_at ? "write quantity 1, and a group for each object" : "write quantity 2");
    }
    return good;
  }

  /// What links cannot hold.
  bool CheckLinks(Configuration& configuration, const Scene& scene) {
    bool good = true;
    for (const Group& group : scene.groups) {
      if (!group.HasLinks()) continue;
      const Call* location = AsCall(group.settings.Get("location"));
      std::string why, hint;
      if (group.settings.WordOr("mass") == "fixed") {
        why = "never move, and links would hold nothing";
        hint = "give them a mass";
      } else if (group.settings.Count("quantity") == 1 && !group.settings.On("links.anchor")) {
        why = "are one object, and without links.anchor there is nothing to link it to";
        hint = "write quantity 2 or links.anchor on";
      } else if (location != nullptr && location->name == "pile") {
        why = "settle in a pile, which links would hang in the air";
        hint = "write another location, line for example";
      }
      if (why.empty()) continue;
      good = false;
      if (!misplaced_.emplace(group.name, why).second) continue;
      diagnostics_.Report(kContradiction,
                          configuration.SpanOf({group.name, FindParameter("links.type", true)},
                                               benchmark_.benchmark->name.span),
                          fmt::format("the {} {}", group.name, why), hint);
    }
    return good;
  }

  /// Whoever names a component wants it left out; where the scene needs it that cannot be.
  bool CheckNeeds(Configuration& configuration, const Scene& scene) {
    if (scene.world.Lists("omit", "auto") || scene.world.Lists("omit", "none")) return true;
    bool good = true;
    for (const Need& need : AnalyseNeeds(scene)) {
      if (need.fate != Fate::kKept || HowAsked(scene, need.component) != Asked::kByName) continue;
      good = false;
      const std::string_view name = InfoOf(need.component).name;
      const dsl::Span span = configuration.SpanOfWord({"", FindParameter("omit", false)}, name);
      if (!needed_.emplace(span.source, span.begin, need.component).second) continue;
      diagnostics_.Report(
          kNeeded, span, fmt::format("'{}' cannot be left out: {}", name, need.why),
          "take it out of the list; omit auto leaves out all that a scene does not need");
    }
    return good;
  }

  void FindLints(Configuration& configuration, const Scene& scene) {
    for (const LintNumber& number : LintScene(scene)) {
      if (!number.IsDoubtful()) continue;
      const auto [at, is_first] = findings_.try_emplace(number.lint);
      LintFinding& finding = at->second;
      finding.runs += plan_.repeats;
      if (number.IsBad()) finding.bad_runs += plan_.repeats;
      if (!is_first && !number.IsWorseThan(finding.worst)) continue;
      finding.worst = number;
      finding.span = SpanOfLint(configuration, scene.groups[number.group].name, number.lint);
    }
  }

  /// The first parameter to blame that the benchmark sets, else its name.
  dsl::Span SpanOfLint(Configuration& configuration, const std::string& group, Lint lint) const {
    std::string_view names = InfoOf(lint).about;
    while (!names.empty()) {
      const std::string_view name = names.substr(0, names.find(' '));
      names.remove_prefix(std::min(names.size(), name.size() + 1));
      const Parameter* of_world = FindParameter(name, false);
      const ParameterKey key = of_world != nullptr ? ParameterKey{"", of_world}
                                                   : ParameterKey{group, FindParameter(name, true)};
      if (configuration.IsSet(key)) return configuration.SpanOf(key, {});
    }
    return benchmark_.benchmark->name.span;
  }

  void ReportLints() {
    for (const auto& [lint, finding] : findings_) {
      std::string where;
      if (plan_.runs.size() > 1) {
        where = fmt::format("; in {} of {} runs", finding.runs, plan_.runs.size());
        if (finding.bad_runs > 0 && finding.bad_runs < finding.runs)
          where += fmt::format(", beyond the limit in {}", finding.bad_runs);
      }
      diagnostics_.Report(InfoOf(lint).kind, finding.span, LintMessage(finding.worst) + where,
                          LintRemedy(finding.worst));
    }
  }

  /// What is said of errors has to lead to some, and their samples to lie on everyone's cycles.
  bool CheckAccuracy(Configuration& configuration, const Scene& scene) {
    const dsl::Span name = benchmark_.benchmark->name.span;
    const auto& settings = configuration.layers().settings;
    const ParameterKey metrics{"", FindParameter("accuracy.metrics", false)};
    const auto said = std::ranges::find_if(settings, [](const auto& setting) {
      return setting.first.second->name.starts_with("accuracy.");
    });
    if (said != settings.end() && !settings.contains(metrics)) {
      if (std::exchange(inaccurate_, true)) return false;
      diagnostics_.Report(kContradiction, said->second.node->path.span,
                          "accuracy without metrics collects nothing",
                          "say which errors: accuracy.metrics position, energy");
      return false;
    }
    const auto report = [&](const dsl::DiagnosticKind& kind, std::string_view parameter,
                            const std::string& message, const std::string& help) {
      if (!std::exchange(inaccurate_, true))
        diagnostics_.Report(kind, configuration.SpanOf({"", FindParameter(parameter, false)}, name),
                            message, help);
      return false;
    };
    const AccuracyFault fault = FindAccuracyFault(scene);
    if (!fault.parameter.empty())
      return report(kContradiction, fault.parameter, fault.message, fault.help);
    const auto sampling = SamplingOf(scene);
    if (!sampling) return true;
    if (!interval_s_) interval_s_ = sampling->interval_s;
    if (*interval_s_ != sampling->interval_s)
      return report(kMisplacedSweep, "accuracy.interval", "the interval is the same in every run",
                    "their samples are one axis");
    return true;
  }

  const Scenario& scenario_;
  const BenchmarkRef& benchmark_;
  dsl::Diagnostics& diagnostics_;
  bool lints_;
  int errors_before_;
  LayeredBenchmark layered_;
  std::vector<std::size_t> case_extents_, extents_;
  std::vector<std::unique_ptr<Configuration>> configurations_;
  std::vector<GridAxis> grid_;
  Plan plan_;
  bool capacity_reported_ = false;
  /// Groups, and their layouts or what is wrong with their links, as reported.
  std::set<std::pair<std::string, std::string>> misplaced_;
  /// Words of `omit` that were refused: the reason may be another one in each run.
  std::set<std::tuple<const dsl::Source*, std::size_t, Component>> needed_;
  /// Settings, and words of `record`, that do not go with a trace, as reported.
  std::set<std::pair<ParameterKey, std::string>> untraceable_;
  std::map<Lint, LintFinding> findings_;
  bool inaccurate_ = false;           ///< a fault in what is said of accuracy is reported
  std::optional<double> interval_s_;  ///< of the samples, once some run has any
  /// A point has an error, which another benchmark may have reported already.
  bool broken_ = false;
};

}  // namespace

std::optional<Plan> Expand(const Scenario& scenario, const BenchmarkRef& benchmark,
                           dsl::Diagnostics& diagnostics, bool lints) {
  return Expander(scenario, benchmark, diagnostics, lints).Run();
}

}  // namespace cdb::compiler
