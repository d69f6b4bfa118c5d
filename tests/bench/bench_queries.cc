// Queries by Bullet and by cdb's tree, in one program, in each cycle in alternation, the order
// swapped each time: ns of processor time a query, and the adaptation of the tree to the poses.
// Usage: bench_queries_f32 [CYCLES] [QUERIES]

#include <fmt/format.h>
#include <time.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string_view>
#include <vector>

#include "runtime/engine/scene_queries/queries.h"
#include "runtime/engine/world/engine.h"
#include "tests/bench/median.h"
#include "tests/support/scene.h"

namespace cdb::bench {
namespace {

/// ns of this thread: a batch of Bullet's takes longer than a time slice, so that wall time would
/// count what other programs did meanwhile.
std::int64_t ProcessorTime() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return std::int64_t{1000000000} * now.tv_sec + now.tv_nsec;
}

/// Objects of four shapes that fill a tenth of the cube, at rest or in motion.
plan::Scene SceneOf(std::uint64_t objects, bool moves, const char* type, std::uint64_t queries) {
  const double side = std::cbrt(10.0 * static_cast<double>(objects));
  plan::Scene scene = tests::DefaultScene(objects, side);
  tests::SetWorld(scene, "precision", tests::Word(world::EnginePrecision()));
  tests::SetWorld(scene, "record", schema::WordList{});
  tests::SetWorld(scene, "acceleration", Eigen::Vector3d(Eigen::Vector3d::Zero()));
  tests::SetGroup(scene, "type", tests::AnyType());
  tests::SetGroup(scene, "size", 1.0);
  tests::SetGroup(scene, "orientation", tests::Word("random"));
  if (moves)
    tests::SetGroup(scene, "linear_velocity",
                    tests::Uniform(Eigen::Vector3d(Eigen::Vector3d::Constant(-2)),
                                   Eigen::Vector3d(Eigen::Vector3d::Constant(2))));
  plan::GroupSettings& asked = scene.queries.emplace_back(plan::Queries{"asked", {}}).settings;
  asked.Set("queries.type", tests::Word(type));
  asked.Set("queries.count", queries);
  if (std::string_view(type) == "nearest") asked.Set("queries.implementation", tests::Word("tree"));
  tests::SeedStreams(scene);
  return scene;
}

void Run(std::uint64_t objects, bool moves, const char* type, std::uint64_t cycles,
         std::uint64_t queries) {
  const plan::Scene scene = SceneOf(objects, moves, type, queries);
  world::Engine engine(scene, layouts::MakeInitialState(scene), omissions::KeepEverything(scene));
  const std::vector<scene_queries::QueryBlock> blocks = scene_queries::DrawQueries(scene);
  const scene_queries::QueryBlock& block = blocks[0];
  std::vector<cdb::queries::Ray<btScalar>> rays;
  for (const auto& ray : block.rays)
    rays.push_back(
        {ray.from.cast<btScalar>(), ray.along.cast<btScalar>(), static_cast<btScalar>(ray.length)});
  std::unique_ptr<scene_queries::BulletQueries> bullet;
  if (!block.by_tree) bullet = std::make_unique<scene_queries::BulletQueries>(engine, block);
  scene_queries::TreeQueries tree(engine);
  scene_queries::Answers by_bullet, by_tree;
  std::vector<double> bullet_times, tree_times, update_times;
  double bullet_hits = 0, tree_hits = 0;
  for (std::uint64_t cycle = 0; cycle < cycles; ++cycle) {
    engine.Step();
    const auto ask_bullet = [&] {
      by_bullet.Clear();
      const auto begin = ProcessorTime();
      bullet->Ask(by_bullet);
      bullet_times.push_back(static_cast<double>(ProcessorTime() - begin));
      bullet_hits += static_cast<double>(by_bullet.hits.size());
    };
    if (bullet != nullptr && cycle % 2 == 0) ask_bullet();
    by_tree.Clear();
    const auto begin = ProcessorTime();
    tree.Update();
    const auto middle = ProcessorTime();
    tree.Ask(block, rays, by_tree);
    const auto end = ProcessorTime();
    update_times.push_back(static_cast<double>(middle - begin));
    tree_times.push_back(static_cast<double>(end - middle));
    tree_hits += static_cast<double>(by_tree.hits.size());
    if (bullet != nullptr && cycle % 2 == 1) ask_bullet();
  }
  const auto count = static_cast<double>(queries);
  const double tree_ns = Median(tree_times) / count, update = Median(update_times);
  const double bullet_ns = bullet ? Median(bullet_times) / count : 0;
  const double asked = count * static_cast<double>(cycles);
  fmt::print("{:<8} {:>6} {:<9} {:>9} {:>9.0f} {:>10.1f} {:>9} {:>9} {:>7} {:>7.3f}\n", type,
             objects, moves ? "in motion" : "at rest",
             bullet ? fmt::format("{:.0f}", bullet_ns) : "-", tree_ns, update / 1e3,
             bullet ? fmt::format("{:.1f}", bullet_ns / tree_ns) : "-",
             bullet ? fmt::format("{:.1f}", bullet_ns / (tree_ns + update / count)) : "-",
             bullet ? fmt::format("{:.3f}", bullet_hits / asked) : "-", tree_hits / asked);
  std::fflush(stdout);
}

}  // namespace
}  // namespace cdb::bench

int main(int argc, char** argv) {
  const auto argument = [&](int i, std::uint64_t otherwise) {
    return argc > i ? std::strtoull(argv[i], nullptr, 10) : otherwise;
  };
  const std::uint64_t cycles = argument(1, 30), queries = argument(2, 1000);
  fmt::print(
      "{} precision, dbvt, {} cycles of {} queries; medians; ns of processor time a query; update "
      "of the tree in us; "
      "times faster without and with it; hits a query\n"
      "{:<8} {:>6} {:<9} {:>9} {:>9} {:>10} {:>9} {:>9} {:>7} {:>7}\n",
      cdb::world::EnginePrecision(), cycles, queries, "type", "N", "", "bullet", "tree", "update",
      "faster", "with it", "bullet", "tree");
  for (const char* type : {"ray", "sweep", "overlap", "nearest"})
    for (const std::uint64_t objects : {100, 1000, 10000})
      for (const bool moves : {false, true}) cdb::bench::Run(objects, moves, type, cycles, queries);
}
