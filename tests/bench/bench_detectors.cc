// Broad phases compared on the same moving boxes: cdb's, Bullet's dbvt, and those in shared
// libraries. All in one process, in blocks of cycles in turn. Means are processor time of the
// calling thread (with -t elapsed time, as other threads work too); median and worst cycle and the
// start are elapsed time. The start is Prepare and the first cycle, and not part of the rest. The
// pairs of the last cycle are checked. Ratios are of means: dbvt's to that of each detector, and
// that of the best detector that is not cdb's.
//
// Usage: bench_detectors [-t THREADS] [-c CYCLES] [-b BLOCK] [-s SCENE]... [-o NAME]... [-w]
//                        [-d FOLDER WITH SHARED LIBRARIES] [N ...]
// -w: six walls whose boxes are infinite. -o: only these detectors, and dbvt.

#include <btBulletCollisionCommon.h>
#include <fmt/format.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "library/detectors/builtin/builtin.h"
#include "library/detectors/exact_pairs.h"
#include "library/detectors/plugin.h"
#include "tests/bench/median.h"
#include "tests/library/detectors/box_scenes.h"

namespace cdb::bench {
namespace {

double HeapBytes() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks) + static_cast<double>(info.hblkhd);
}

double Seconds(clockid_t clock) {
  timespec time;
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Bullet's, fed as its world does: boxes that did not change are not set, as those of sleepers are
/// not. Bodies are added shuffled, as rows of them degenerate its tree. If it `lists`, it copies
/// its pairs as every detector has to, else they stay where they are.
class Dbvt final : public Detector {
 public:
  explicit Dbvt(bool lists) : lists_(lists) {}
  void Prepare(const Scene& scene) override {
    boxes_.assign(scene.boxes.begin(), scene.boxes.end());
    proxies_.resize(scene.size);
    std::vector<Id> order(scene.size);
    for (Id id = 0; id < scene.size; ++id) order[id] = id;
    std::shuffle(order.begin(), order.end(), std::mt19937(1));
    for (const Id id : order) {
      const Filter& filter = scene.filters[id];
      proxies_[id] = broad_phase_.createProxy(
          Corner(boxes_[id].lower), Corner(boxes_[id].upper), 0,
          reinterpret_cast<void*>(static_cast<std::uintptr_t>(id)), static_cast<int>(filter.group),
          static_cast<int>(filter.mask), nullptr);
    }
  }
  void FindPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    for (Id id = 0; id < scene.size; ++id) {
      const Box& box = scene.boxes[id];
      if (std::memcmp(&box, &boxes_[id], sizeof box) == 0) continue;
      boxes_[id] = box;
      broad_phase_.setAabb(proxies_[id], Corner(box.lower), Corner(box.upper), nullptr);
    }
    broad_phase_.calculateOverlappingPairs(nullptr);
    if (!lists_) return;
    const btBroadphasePairArray& all =
        broad_phase_.getOverlappingPairCache()->getOverlappingPairArray();
    for (int i = 0; i < all.size(); ++i) {
      const Id a = IdOf(all[i].m_pProxy0), b = IdOf(all[i].m_pProxy1);
      pairs.push_back({std::min(a, b), std::max(a, b)});
    }
  }

 private:
  static Id IdOf(const btBroadphaseProxy* proxy) {
    return static_cast<Id>(reinterpret_cast<std::uintptr_t>(proxy->m_clientObject));
  }
  static btVector3 Corner(const Vec3& at) {  // Bullet's planes end at 1e18
    const auto held = [](double x) { return static_cast<btScalar>(std::clamp(x, -1e18, 1e18)); };
    return {held(at.x), held(at.y), held(at.z)};
  }
  const bool lists_;
  btDbvtBroadphase broad_phase_;
  std::vector<btBroadphaseProxy*> proxies_;
  std::vector<Box> boxes_;
};

struct Competitor {
  std::string name;
  bool is_builtin = false;
  std::unique_ptr<Detector> detector;
  std::vector<Pair> pairs = {};
  std::vector<double> cycles = {};  ///< seconds
  double start = 0, bytes = 0;
  double total = 0;  ///< of all cycles but the first, on the chosen clock
  std::string note = {};
};

struct Settings {
  Options options;
  std::size_t cycles = 0, block = 20;
  std::vector<std::string> scenes, only, libraries;
  bool walls = false;
};

/// What one may take for a scene before it is left out.
constexpr double kPatience = 20;

std::vector<Competitor> MakeCompetitors(const Settings& settings, std::size_t bodies) {
  std::vector<Competitor> competitors;
  const auto add = [&](const DetectorEntry& entry, bool is_builtin) {
    const bool is_asked =
        settings.only.empty() || std::ranges::count(settings.only, entry.name) > 0;
    if (!is_asked || !HasAny(entry.phases, kBroad)) return;
    if (entry.max_bodies != 0 && bodies > entry.max_bodies) return;
    competitors.push_back({.name = entry.name,
                           .is_builtin = is_builtin,
                           .detector = std::unique_ptr<Detector>(entry.make(settings.options))});
  };
  competitors.push_back({.name = "dbvt", .detector = std::make_unique<Dbvt>(false)});
  competitors.push_back({.name = "dbvt, listed", .detector = std::make_unique<Dbvt>(true)});
  for (const DetectorEntry& entry : builtin::BuiltinDetectors()) add(entry, true);
  for (const std::string& path : settings.libraries) {
    const Plugin& plugin = detectors::LoadPlugin(path);
    for (std::size_t i = 0; i < plugin.count; ++i) add(plugin.entries[i], false);
  }
  return competitors;
}

/// The mean is of whole blocks by `clock`, which is a system call where it is the thread's own;
/// each cycle is timed by the cheap clock of elapsed time.
void RunBlock(Competitor& competitor, Scene scene, std::span<const std::vector<Box>> frames,
              bool is_first, clockid_t clock) {
  if (!competitor.note.empty()) return;
  const double heap = HeapBytes();
  try {
    double begin = Seconds(clock);
    for (const std::vector<Box>& frame : frames) {
      scene.boxes = frame;
      competitor.pairs.clear();
      const double cycle_begin = Seconds(CLOCK_MONOTONIC);
      if (is_first) competitor.detector->Prepare(scene);
      competitor.detector->FindPairs(scene, competitor.pairs);
      const double took = Seconds(CLOCK_MONOTONIC) - cycle_begin;
      if (is_first) {
        competitor.start = took;
        begin = Seconds(clock);
      } else {
        competitor.cycles.push_back(took);
      }
      is_first = false;
    }
    competitor.total += Seconds(clock) - begin;
  } catch (const std::exception& error) {
    competitor.note = error.what();
  }
  competitor.bytes += HeapBytes() - heap;
  if (competitor.start + competitor.total > kPatience) competitor.note = "gave up";
}

void RunScene(const Settings& settings, std::string_view name, std::size_t objects) {
  const clockid_t clock = settings.options.threads > 1 ? CLOCK_MONOTONIC : CLOCK_THREAD_CPUTIME_ID;
  // A box a frame is 48 bytes: no more than a block is kept.
  const std::size_t block = std::clamp<std::size_t>(4000000 / objects, 2, settings.block);
  const std::size_t cycles =
      settings.cycles != 0 ? settings.cycles : std::clamp<std::size_t>(8000000 / objects, 8, 400);
  tests::BoxScene moving(name, objects, settings.walls);
  std::vector<Competitor> competitors = MakeCompetitors(settings, moving.View().size);
  std::mt19937 random(1);
  std::vector<std::size_t> turns(competitors.size());
  for (std::size_t i = 0; i < turns.size(); ++i) turns[i] = i;
  std::vector<std::vector<Box>> frames(block);
  for (std::size_t cycle = 0; cycle < cycles; cycle += block) {
    for (std::vector<Box>& frame : frames) {
      const Scene scene = moving.View();
      frame.assign(scene.boxes.begin(), scene.boxes.end());
      moving.Move();
    }
    // Whoever comes first, or after one that needs much memory, finds the boxes further away.
    std::ranges::shuffle(turns, random);
    for (const std::size_t turn : turns) {
      RunBlock(competitors[turn], moving.View(), frames, cycle == 0, clock);
    }
  }
  Scene last = moving.View();
  last.boxes = frames.back();
  double dbvt = 0, best = 0;
  std::string best_name;
  const auto mean = [](const Competitor& competitor) {
    return competitor.total /
           static_cast<double>(std::max<std::size_t>(1, competitor.cycles.size()));
  };
  for (const Competitor& competitor : competitors) {
    if (!competitor.note.empty() || competitor.cycles.empty()) continue;
    if (competitor.name == "dbvt") dbvt = mean(competitor);
    if (!competitor.is_builtin && (best_name.empty() || mean(competitor) < best)) {
      best = mean(competitor);
      best_name = competitor.name;
    }
  }
  fmt::print("\n{}, {} objects{}: {} cycles; best third-party {}\n", name, objects,
             settings.walls ? " and 6 walls" : "", cycles, best_name);
  fmt::print("{:<17} {:>10} {:>10} {:>10} {:>10}{:>9}{:>8}{:>8}{:>9}  {}\n", "", "mean ms",
             "median", "worst", "start", "pairs", "/dbvt", "/best", "MiB", "wrong");
  for (Competitor& competitor : competitors) {
    if (competitor.cycles.empty()) competitor.cycles.push_back(competitor.start);
    const std::size_t pairs = competitor.pairs.size();
    std::string wrong;
    if (competitor.name != "dbvt" && competitor.name != "null" && competitor.note.empty()) {
      const detectors::PairFaults faults =
          detectors::ComparePairs(last, std::move(competitor.pairs));
      if (faults.missed + faults.false_positives + faults.duplicate > 0)
        wrong = fmt::format("{} missed, {} false, {} twice", faults.missed, faults.false_positives,
                            faults.duplicate);
    }
    fmt::print(
        "{:<17} {:>10.4f} {:>10.4f} {:>10.4f} {:>10.3f}{:>9}{:>8.1f}{:>8.1f}{:>9.1f}  {}{}\n",
        competitor.name, 1e3 * mean(competitor), 1e3 * Median(competitor.cycles),
        1e3 * std::ranges::max(competitor.cycles), 1e3 * competitor.start, pairs,
        dbvt / mean(competitor), best / mean(competitor), competitor.bytes / 1048576, wrong,
        competitor.note);
    std::fflush(stdout);
  }
}

int Main(int argc, char** argv) {
  Settings settings;
  std::string folder;
  for (int option; (option = getopt(argc, argv, "t:c:b:s:o:d:w")) != -1;) {
    switch (option) {
      case 't':
        settings.options.threads = static_cast<unsigned>(std::atoi(optarg));
        break;
      case 'c':
        settings.cycles = static_cast<std::size_t>(std::atoll(optarg));
        break;
      case 'b':
        settings.block = static_cast<std::size_t>(std::atoll(optarg));
        break;
      case 's':
        settings.scenes.push_back(optarg);
        break;
      case 'o':
        settings.only.push_back(optarg);
        break;
      case 'd':
        folder = optarg;
        break;
      case 'w':
        settings.walls = true;
        break;
      default:
        return 2;
    }
  }
  if (!folder.empty())
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      if (entry.path().extension() == ".so") settings.libraries.push_back(entry.path());
  std::ranges::sort(settings.libraries);
  if (settings.scenes.empty())
    settings.scenes.assign(std::begin(tests::kBoxScenes), std::end(tests::kBoxScenes));
  std::vector<std::size_t> sizes;
  for (; optind < argc; ++optind)
    sizes.push_back(static_cast<std::size_t>(std::atof(argv[optind])));
  if (sizes.empty()) sizes = {1000, 5000, 20000};
  for (const std::string& scene : settings.scenes)
    for (const std::size_t size : sizes) RunScene(settings, scene, size);
  return 0;
}

}  // namespace
}  // namespace cdb::bench

using namespace cdb;
using namespace cdb::bench;

int main(int argc, char** argv) { return Main(argc, argv); }
