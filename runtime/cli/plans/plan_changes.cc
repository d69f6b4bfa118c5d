#include "runtime/cli/plans/plan_changes.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "compiler/schema/schema.h"

namespace cdb::plans {
namespace {

using Texts = std::vector<std::string>;

/// The distinct values of each parameter over the runs of a plan, as they are written in `.cdb`, in
/// the order of the grid.
class ValuesOfPlan {
 public:
  explicit ValuesOfPlan(const plan::Plan& plan) {
    const std::vector<std::size_t>* last = nullptr;
    for (const plan::Run& run : plan.Bounds()) {
      // Repeats have the same scene.
      if (last != nullptr && !run.at.empty() && run.at == *last) continue;
      last = &run.at;
      // Groups first: defaults of the world may follow from them.
      for (const plan::Group& group : run.scene.groups) Note(group.name, group.settings);
      for (const plan::Joint& joint : run.scene.joints)
        Note(joint.name, joint.settings, schema::kJointsBlock);
      for (const plan::Queries& queries : run.scene.queries)
        Note(queries.name, queries.settings, schema::kQueriesBlock);
      Note("", run.scene.world);
      for (const schema::PluginDetector& plugin : run.scene.plugins)
        Note("plug-in of " + plugin.name, plugin.sha256.substr(0, 12));
    }
    if (plan.repeats > 0) Note("repeats", fmt::format("{}", plan.repeats));
  }

  const std::vector<std::pair<std::string, Texts>>& all() const { return all_; }
  const Texts* Find(const std::string& name) const {
    const auto found = std::ranges::find(all_, name, [](const auto& each) { return each.first; });
    return found == all_.end() ? nullptr : &found->second;
  }

 private:
  void Note(const std::string& group, const plan::Settings& settings, std::string_view block = {}) {
    const std::span<const schema::Parameter> schema = schema::Schema();
    std::vector<const schema::Value*>& last = last_[group];
    last.resize(schema.size(), nullptr);
    for (std::size_t i = 0; i < schema.size(); ++i) {
      const schema::Parameter& parameter = schema[i];
      if (parameter.grouped == group.empty() || parameter.NamedBlock() != block) continue;
      if (!settings.Has(parameter) && plan::ValueIfAbsent(parameter) == nullptr) continue;
      const schema::Value& value = settings.ValueOf(parameter);
      if (last[i] != nullptr && (last[i] == &value || *last[i] == value)) continue;
      last[i] = &value;
      Note(group + (group.empty() ? "" : ".") + std::string(parameter.OwnName()),
           schema::LabelOf(value));
    }
  }

  void Note(const std::string& name, const std::string& text) {
    auto found = std::ranges::find(all_, name, [](const auto& each) { return each.first; });
    if (found == all_.end()) found = all_.insert(all_.end(), {name, {}});
    if (std::ranges::find(found->second, text) == found->second.end())
      found->second.push_back(text);
  }

  std::vector<std::pair<std::string, Texts>> all_;
  /// The value of the last run, in the order of the schema, by the name of the group.
  std::map<std::string, std::vector<const schema::Value*>> last_;
};

/// Those of `texts` that `others` lacks.
Texts OnlyIn(const Texts& texts, const Texts& others) {
  Texts only;
  std::ranges::copy_if(texts, std::back_inserter(only), [&](const std::string& text) {
    return std::ranges::find(others, text) == others.end();
  });
  return only;
}

std::string Joined(const Texts& texts) {
  constexpr std::size_t kMost = 4;
  const auto first = std::span(texts).first(std::min(texts.size(), kMost));
  return fmt::format("{}{}", fmt::join(first, ", "),
                     texts.size() > kMost ? fmt::format(", … ({})", texts.size()) : "");
}

/// Empty if no value differs.
std::string ChangeOf(const std::string& name, const Texts& before, const Texts& now) {
  const Texts gone = OnlyIn(before, now), added = OnlyIn(now, before);
  if (gone.empty() && added.empty()) return {};
  if (gone.empty()) return fmt::format("{} + {}", name, Joined(added));
  if (added.empty()) return fmt::format("{} - {}", name, Joined(gone));
  return fmt::format("{} {} -> {}", name, Joined(gone), Joined(added));
}

/// That of its search; empty if it has none.
Texts ConditionOf(const plan::Plan& plan) {
  const auto axis = plan.SearchAxis();
  return axis ? Texts{plan.axes[*axis].search->until.text} : Texts{};
}

}  // namespace

std::string DescribeChanges(const plan::Plan& before, const plan::Plan& now) {
  const ValuesOfPlan of_before(before), of_now(now);
  Texts changes;
  const auto note = [&changes](std::string change) {
    if (!change.empty()) changes.push_back(std::move(change));
  };
  for (const auto& [name, texts] : of_now.all()) {
    const Texts* const earlier = of_before.Find(name);
    note(ChangeOf(name, earlier == nullptr ? Texts() : *earlier, texts));
  }
  for (const auto& [name, texts] : of_before.all())
    if (of_now.Find(name) == nullptr) note(ChangeOf(name, texts, {}));
  note(ChangeOf("until", ConditionOf(before), ConditionOf(now)));
  if (changes.empty()) return before.skipped != now.skipped ? "skip" : "other runs";
  constexpr std::size_t kMost = 4;
  const std::size_t others = changes.size() > kMost ? changes.size() - kMost : 0;
  changes.resize(changes.size() - others);
  return fmt::format("{}{}", fmt::join(changes, ", "),
                     others > 0 ? fmt::format(" and {} more", others) : "");
}

}  // namespace cdb::plans
