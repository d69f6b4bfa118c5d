// Facts about joints between groups, for lints about the objects that they hold.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/lints/lint_facts.h"

namespace cdb::lints {
namespace {

/// The groups that joints hold together: what each is joined to, by index into Scene::groups.
struct Graph {
  std::vector<std::vector<std::size_t>> neighbours;
  std::vector<char> is_held;  ///< by the world, or by what cannot move
};

/// The group at an end of a joint; nullopt for the world and what cannot move.
std::optional<std::size_t> EndOf(const plan::Scene& scene, std::string_view name) {
  const auto found = std::ranges::find(scene.groups, name, &plan::Group::name);
  if (found == scene.groups.end() || found->settings.WordOr("mass") == "fixed") return std::nullopt;
  return static_cast<std::size_t>(found - scene.groups.begin());
}

/// The groups of its parent and its child.
std::array<std::optional<std::size_t>, 2> EndsOf(const plan::Scene& scene,
                                                 const plan::Joint& joint) {
  return {EndOf(scene, joint.settings.WordOr("joints.parent")),
          EndOf(scene, joint.settings.WordOr("joints.child"))};
}

Graph GraphOf(const plan::Scene& scene) {
  Graph graph{std::vector<std::vector<std::size_t>>(scene.groups.size()),
              std::vector<char>(scene.groups.size(), 0)};
  for (const plan::Joint& joint : scene.joints) {
    if (!scene.HoldsObjects(joint)) continue;
    const auto [parent, child] = EndsOf(scene, joint);
    if (parent && child) {
      graph.neighbours[*parent].push_back(*child);
      graph.neighbours[*child].push_back(*parent);
    } else if (parent || child) {
      graph.is_held[parent ? *parent : *child] = 1;
    }
  }
  return graph;
}

/// kg: of the groups beyond each one, as seen from the roots. `order`: the roots, to which those
/// that are reached from them are added, each after the one that it hangs on.
std::vector<double> BeyondOf(const Graph& graph, const std::vector<double>& masses,
                             std::vector<std::size_t> order) {
  std::vector<std::size_t> above(masses.size(), masses.size());
  std::vector<char> is_seen(masses.size(), 0);
  for (const std::size_t root : order) is_seen[root] = 1;
  for (std::size_t i = 0; i < order.size(); ++i)
    for (const std::size_t next : graph.neighbours[order[i]]) {
      if (is_seen[next] != 0) continue;
      is_seen[next] = 1;
      above[next] = order[i];
      order.push_back(next);
    }
  std::vector<double> beyond(masses.size(), 0);
  for (std::size_t i = order.size(); i-- > 0;)
    if (above[order[i]] < masses.size())
      beyond[above[order[i]]] += beyond[order[i]] + masses[order[i]];
  return beyond;
}

/// All groups of the tree of `first`.
std::vector<std::size_t> TreeOf(const Graph& graph, std::size_t first, std::vector<char>& is_seen) {
  std::vector<std::size_t> tree = {first};
  is_seen[first] = 1;
  for (std::size_t i = 0; i < tree.size(); ++i)
    for (const std::size_t next : graph.neighbours[tree[i]])
      if (std::exchange(is_seen[next], char{1}) == 0) tree.push_back(next);
  return tree;
}

bool Turns(std::string_view type) {
  return type == "hinge" || type == "ball" || type == "universal";
}

/// Groups that joints hold together.
struct Tree {
  double mass = 0, momentum = 0;  ///< kg; kg rad/s
  bool is_held = false, turns = false;
};

/// rad/s: the speed that a motor seeks, or that a torque may give in the course of the run.
double SpinOf(const plan::Joint& joint, const GroupFacts& objects, double time) {
  if (joint.settings.WordOr("joints.type") != "hinge") return 0;
  const auto number = [&](schema::GroupParameter parameter) {
    const schema::Number* value = schema::AsNumber(joint.settings.Get(parameter));
    return value == nullptr ? 0 : std::abs(value->AsReal());
  };
  const bool is_free = schema::AsNumber(joint.settings.Get("joints.limits.upper")) == nullptr &&
                       number("joints.damping") == 0 && number("joints.friction") == 0;
  const double inertia = objects.mass.least * std::pow(objects.longest_side, 2) / 6;
  const double gained = is_free ? number("joints.motor.torque") * time / inertia : 0;
  return std::max(number("joints.motor.velocity"), gained);
}

}  // namespace

void FindTrees(const plan::Scene& scene, SceneFacts& facts) {
  if (scene.world.WordOr("coordinates") != "reduced") return;
  const Graph graph = GraphOf(scene);
  std::vector<std::size_t> tree_of(scene.groups.size());
  std::vector<Tree> trees;
  std::vector<char> is_seen(scene.groups.size(), 0);
  for (std::size_t i = 0; i < tree_of.size(); ++i) {
    if (is_seen[i] != 0) continue;
    trees.emplace_back();
    for (const std::size_t k : TreeOf(graph, i, is_seen)) {
      tree_of[k] = trees.size() - 1;
      trees.back().is_held = trees.back().is_held || graph.is_held[k] != 0;
    }
  }
  for (const plan::Joint& joint : scene.joints) {
    if (!scene.HoldsObjects(joint) || !Turns(joint.settings.WordOr("joints.type"))) continue;
    for (const auto& end : EndsOf(scene, joint))
      if (end) trees[tree_of[*end]].turns = true;
  }
  for (const GroupFacts& objects : facts.groups) {
    Tree& tree = trees[tree_of[objects.index]];
    tree.mass += objects.quantity * objects.mass.most;
    tree.momentum += objects.quantity * objects.mass.most * objects.spin;
    if (!objects.chained) continue;
    tree.is_held = tree.is_held || objects.settings->On("links.anchor");
    tree.turns = tree.turns || Turns(objects.settings->WordOr("links.type"));
  }
  for (GroupFacts& objects : facts.groups) {
    const Tree& tree = trees[tree_of[objects.index]];
    if (tree.turns && !tree.is_held && tree.mass > 0) objects.tumble = tree.momentum / tree.mass;
  }
}

void FindLoads(const plan::Scene& scene, SceneFacts& facts) {
  if (scene.joints.empty()) return;
  std::vector<GroupFacts*> groups(scene.groups.size(), nullptr);
  std::vector<double> masses(scene.groups.size(), 0);
  for (GroupFacts& objects : facts.groups) {
    groups[objects.index] = &objects;
    masses[objects.index] = objects.mass.most * (objects.chained ? objects.quantity : 1);
  }
  for (const plan::Joint& joint : scene.joints) {
    if (!scene.HoldsObjects(joint)) continue;
    const auto child = EndsOf(scene, joint)[1];
    if (child && groups[*child] != nullptr && groups[*child]->mass.least > 0)
      groups[*child]->driven_spin =
          std::max(groups[*child]->driven_spin, SpinOf(joint, *groups[*child], facts.Time()));
  }
  if (scene.world.WordOr("coordinates") != "maximal") return;
  const Graph graph = GraphOf(scene);
  std::vector<char> is_seen(masses.size(), 0);
  for (std::size_t i = 0; i < masses.size(); ++i) {
    if (is_seen[i] != 0 || graph.neighbours[i].empty()) continue;
    const std::vector<std::size_t> tree = TreeOf(graph, i, is_seen);
    std::vector<std::size_t> roots;
    double whole = 0;
    for (const std::size_t k : tree) {
      if (graph.is_held[k] != 0) roots.push_back(k);
      whole += masses[k];
    }
    const bool is_free = roots.empty();
    if (is_free)
      roots.push_back(
          *std::ranges::max_element(tree, {}, [&](std::size_t k) { return masses[k]; }));
    const std::vector<double> beyond = BeyondOf(graph, masses, roots);
    for (const std::size_t k : tree) {
      if (groups[k] == nullptr || groups[k]->chained || !(groups[k]->mass.least > 0)) continue;
      // What stands on the ground may carry the rest from any side.
      const double load = is_free ? std::max(beyond[k], whole - beyond[k] - masses[k]) : beyond[k];
      groups[k]->joined_load = load / groups[k]->mass.least;
      groups[k]->is_load_open = is_free;
    }
  }
}

}  // namespace cdb::lints
