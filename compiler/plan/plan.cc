#include "compiler/plan/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "compiler/plan/input_file.h"
#include "compiler/schema/schema.h"
#include "dsl/text/check.h"

namespace cdb::plan {
namespace {

std::string CanonicalText(const Settings& settings) {
  std::string text;
  for (const auto& [name, value] : settings) text += CanonicalLine(name, value);
  return text;
}

std::string CanonicalText(const Scene& scene) {
  std::string text = CanonicalText(scene.world) + CanonicalLine(scene.role);
  for (const Group& group : scene.groups)
    text += fmt::format("group {}\n{}", group.name, CanonicalText(group.settings));
  for (const Joint& joint : scene.joints)
    text += fmt::format("joint {}\n{}", joint.name, CanonicalText(joint.settings));
  for (const Queries& queries : scene.queries)
    text += fmt::format("queries {}\n{}", queries.name, CanonicalText(queries.settings));
  return text + CanonicalTail(scene);
}

}  // namespace

std::string CoordinateText(const Coordinate& coordinate) {
  if (const auto* number = std::get_if<double>(&coordinate)) return schema::FormatReal(*number);
  return std::get<std::string>(coordinate);
}

std::string CanonicalLine(std::string_view name, const schema::Value& value) {
  return fmt::format("{} {}\n", name, schema::ToText(value));
}

std::string CanonicalLine(Role role) {
  return role == Role::kMeasured ? "" : fmt::format("role {}\n", RoleName(role));
}

std::string CanonicalTail(const Scene& scene) {
  std::string text;
  for (const auto& [stream, seed] : scene.seeds)
    text += fmt::format("seed {} {:#x}\n", stream, seed);
  for (const schema::PluginDetector& plugin : scene.plugins)
    text += fmt::format("plugin {} {} {} {} {}\n", plugin.name, plugin.sha256, plugin.max_bodies,
                        plugin.phases, schema::ToText(schema::Value(schema::Text{plugin.path})));
  return text;
}

std::string_view RoleName(Role role) {
  constexpr std::string_view kNames[] = {"measured", "reference", "twin"};
  return kNames[static_cast<std::size_t>(role)];
}

bool Group::HasLinks() const {
  return settings.Count("quantity") > 0 && settings.WordOr("links.type") != "none";
}

const Group* Scene::FindGroup(std::string_view name) const {
  const auto found = std::ranges::find(groups, name, &Group::name);
  return found == groups.end() ? nullptr : &*found;
}

std::string Scene::PulledGroup() const {
  const auto linked = std::ranges::find_if(groups, &Group::HasLinks);
  if (linked != groups.end()) return linked->name;
  for (const Joint& joint : joints) {
    if (!HoldsObjects(joint)) continue;
    const std::string_view parent = joint.settings.WordOr("joints.parent");
    return std::string(parent != kWorldWord ? parent : joint.settings.WordOr("joints.child"));
  }
  return {};
}

bool Scene::HoldsObjects(const Joint& joint) const {
  const auto has_objects = [&](std::string_view name) {
    const Group* group = FindGroup(name);
    return name == kWorldWord || (group != nullptr && group->settings.Count("quantity") > 0);
  };
  return has_objects(joint.settings.WordOr("joints.parent")) &&
         has_objects(joint.settings.WordOr("joints.child"));
}

std::uint64_t Scene::ObjectCount() const {
  std::uint64_t count = 0;
  for (const Group& group : groups) count += group.settings.Count("quantity");
  return count;
}

std::uint64_t Scene::QueryCount() const {
  std::uint64_t count = 0;
  for (const Queries& block : queries) count += block.settings.Count("queries.count");
  return count;
}

void Scene::DropQueries() {
  for (const Queries& block : queries)
    std::erase_if(seeds,
                  [&](const auto& seed) { return seed.first.starts_with(block.name + "."); });
  queries.clear();
}

bool Scene::Uses(std::string_view detector) const {
  return std::ranges::any_of(schema::Schema(), [&](const schema::Parameter& parameter) {
    return parameter.TakesDetectors() &&
           world.ValueOf(parameter) == schema::Value(schema::Word{std::string(detector)});
  });
}

void Scene::KeepUsedPlugins() {
  std::erase_if(plugins,
                [this](const schema::PluginDetector& plugin) { return !Uses(plugin.name); });
}

std::uint64_t StreamSeed(std::uint64_t seed, std::string_view name) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  std::uint64_t z = (seed ^ hash) + 0x9e3779b97f4a7c15;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  return z ^ (z >> 31);
}

bool Axis::IsInteger() const {
  return std::ranges::all_of(values, [](const Coordinate& coordinate) {
    const auto* number = std::get_if<double>(&coordinate);
    return number != nullptr && std::floor(*number) == *number && std::fabs(*number) <= 2147483647;
  });
}

std::string RunIdOf(std::uint64_t rep, std::string_view canonical, int version) {
  return Sha256Hex(fmt::format("plan {}\nrep {}\n{}", version, rep, canonical)).substr(0, 16);
}

std::string RunId(const Scene& scene, std::uint64_t rep) {
  return RunIdOf(rep, CanonicalText(scene));
}

void Plan::ForEachRun(const WholePlan::VisitRun& visit) const {
  if (whole) return whole->for_each_run(visit);
  for (const Run& run : runs) visit(run.id, run.at, run.rep);
}

void Plan::ForEachSkipped(const WholePlan::VisitPoint& visit) const {
  if (whole) return whole->for_each_skipped(visit);
  for (const auto& point : skipped) visit(point);
}

std::string Plan::Sha256() const {
  if (whole) return whole->sha256;
  std::string text = fmt::format("plan {}\n{}\nrepeats {}\n", version, benchmark, repeats);
  for (const Axis& axis : axes) {
    text += fmt::format("axis {} {} {}", axis.name, axis.parameter, axis.unit);
    for (const Coordinate& value : axis.values) text += "\t" + CoordinateText(value);
    text += '\n';
    if (axis.search)
      text += fmt::format("until {} {} {}\n", axis.search->until.figure.Text(),
                          ComparisonText(axis.search->until.comparison),
                          CoordinateText(axis.search->until.limit));
    if (axis.race)
      text += fmt::format("race by {} tolerance {}\n", axis.race->by.Text(),
                          CoordinateText(axis.race->tolerance));
  }
  for (const Run& run : runs)
    text += fmt::format("run {} {} {}\n", run.id, fmt::join(run.at, " "), run.rep);
  for (const auto& point : skipped) text += fmt::format("skip {}\n", fmt::join(point, " "));
  return Sha256Hex(text);
}

void Plan::Renew() {
  if (std::exchange(version, kPlanVersion) == kPlanVersion) return;
  for (Run& run : runs) run.id = RunId(run.scene, run.rep);
}

std::optional<std::size_t> SearchAxis(std::span<const Axis> axes) {
  for (std::size_t i = 0; i < axes.size(); ++i)
    if (axes[i].search) return i;
  return std::nullopt;
}

std::vector<std::size_t> RaceAxes(std::span<const Axis> axes) {
  std::vector<std::size_t> raced;
  for (std::size_t i = 0; i < axes.size(); ++i)
    if (axes[i].race) raced.push_back(i);
  return raced;
}

bool ChoosesRuns(std::span<const Axis> axes) {
  return SearchAxis(axes).has_value() || !RaceAxes(axes).empty();
}

std::uint64_t Plan::MaxCycles() const {
  std::uint64_t most = 0;
  for (const Run& run : Bounds()) most = std::max(most, run.scene.world.Count("cycles"));
  return most;
}

std::uint64_t Plan::MaxObjects() const {
  std::uint64_t most = 0;
  for (const Run& run : Bounds()) most = std::max(most, run.scene.ObjectCount());
  return most;
}

bool Plan::Records(std::string_view what) const {
  return std::ranges::any_of(Bounds(),
                             [&](const Run& run) { return run.scene.world.Lists("record", what); });
}

std::string Describe(const Plan& plan, const Run& run) {
  if (run.scene.role != Role::kMeasured)
    return fmt::format("{} {}", RoleName(run.scene.role), run.id);
  std::string text;
  for (std::size_t i = 0; i < plan.axes.size(); ++i)
    text += fmt::format("{} {}, ", plan.axes[i].name, CoordinateLabel(plan.axes[i], run.at[i]));
  if (plan.repeats > 1 || plan.axes.empty()) return text + fmt::format("rep {}", run.rep);
  return text.substr(0, text.size() - 2);
}

namespace {

constexpr int kWrittenDigits = 6;
constexpr int kLeastDigits = 4;
constexpr int kAllDigits = 17;
constexpr double kNoNeighbour = std::numeric_limits<double>::infinity();

int SignificantDigits(std::string_view text) {
  int digits = 0;
  for (const char c : text.substr(0, text.find('e')))
    digits += c >= '0' && c <= '9' && (digits > 0 || c != '0') ? 1 : 0;
  return digits;
}

/// The nearest values below and above `value` on the axis; infinite if there are none.
struct Neighbours {
  double below = -kNoNeighbour, above = kNoNeighbour;
};

Neighbours NeighboursOf(const Axis& axis, double value) {
  Neighbours neighbours;
  for (const Coordinate& coordinate : axis.values) {
    const auto* number = std::get_if<double>(&coordinate);
    if (number == nullptr) continue;
    const double other = *number;
    if (other < value && other > neighbours.below) neighbours.below = other;
    if (other > value && other < neighbours.above) neighbours.above = other;
  }
  return neighbours;
}

std::string Rounded(double value, int digits) { return fmt::format("{:.{}g}", value, digits); }

// Rounding is monotonic, so a label that differs from those of both neighbours differs from all
// others. A value with a shorter label than `value` would share it at its own number of digits.
std::string Label(double value, const Neighbours& neighbours) {
  const std::string exact = schema::FormatReal(value);
  if (value == std::floor(value) || SignificantDigits(exact) <= kWrittenDigits) return exact;
  // 12345.678 becomes 12346, not 1.235e+04.
  const double size = std::fabs(value);
  const int before_point = size >= 1 && size < 1e12 ? static_cast<int>(std::log10(size)) + 1 : 0;
  for (int digits = std::max(kLeastDigits, before_point); digits < kAllDigits; ++digits) {
    const std::string text = Rounded(value, digits);
    if (text != Rounded(neighbours.below, digits) && text != Rounded(neighbours.above, digits))
      return text;
  }
  return exact;
}

}  // namespace

std::string CoordinateLabel(const Axis& axis, std::size_t index) {
  const auto* number = std::get_if<double>(&axis.values[index]);
  if (number == nullptr) return std::get<std::string>(axis.values[index]);
  return Label(*number, NeighboursOf(axis, *number));
}

std::vector<std::string> CoordinateLabels(const Axis& axis) {
  std::vector<double> sorted;
  for (const Coordinate& coordinate : axis.values)
    if (const auto* number = std::get_if<double>(&coordinate)) sorted.push_back(*number);
  std::ranges::sort(sorted);
  std::vector<std::string> labels;
  for (const Coordinate& coordinate : axis.values) {
    const auto* number = std::get_if<double>(&coordinate);
    if (number == nullptr) {
      labels.push_back(std::get<std::string>(coordinate));
      continue;
    }
    Neighbours neighbours;
    const auto low = std::lower_bound(sorted.begin(), sorted.end(), *number);
    const auto high = std::upper_bound(low, sorted.end(), *number);
    if (low != sorted.begin()) neighbours.below = *(low - 1);
    if (high != sorted.end()) neighbours.above = *high;
    labels.push_back(Label(*number, neighbours));
  }
  return labels;
}

std::string ShortReal(double value) { return Label(value, {}); }

}  // namespace cdb::plan
