// Broad phases compared on the same moving boxes: cdb's, Bullet's dbvt, and those in shared
// libraries. All in one process, in blocks of cycles in turn, several times over the same motion.
//
// Each cycle is timed in processor time of the calling thread (with -t in elapsed time, as other
// threads work too), less the time of the clock, and counts as the fastest of its repeats: a
// detector does the same work in each, so that what interrupted one is no slow cycle. The start is
// Prepare and the first cycle, and not part of the rest. "w/p50" is the worst cycle in medians,
// "spread" how much the slowest repeat took longer than the fastest. The pairs of the last cycle
// are checked, up to 200,000 bodies. Ratios are of means: dbvt's to that of each detector, and that
// of the best detector that is not cdb's.
//
// Usage: bench_detectors [-t THREADS] [-c CYCLES] [-b BLOCK] [-r REPEATS] [-s SCENE]... [-o
// NAME]...
//                        [-w] [-g] [-i] [-d FOLDER WITH SHARED LIBRARIES] [N ...]
// -w: six walls whose boxes are infinite. -o: only these detectors, and dbvt. -g: without dbvt,
// with few cycles, 1000 to 10^6 bodies unless N is given, and at the end how the cost of a cycle
// grows: the exponents of processor time, instructions (see tests/bench/instructions.h; without
// counters in the processor they need Valgrind, and -r 1) and the worst cycle. -i: counts
// instructions in place of time, where 1 ms stands for a million of them.

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
#include "tests/bench/instructions.h"
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

/// What reading the clock takes, which would be much of a short cycle.
double ClockSeconds(clockid_t clock) {
  std::vector<double> times;
  for (int i = 0; i < 1001; ++i) {
    const double begin = Seconds(clock);
    times.push_back(Seconds(clock) - begin);
  }
  return Median(times);
}

struct Competitor {
  std::string name;
  bool is_builtin = false;
  std::vector<std::unique_ptr<Detector>> detectors;  ///< one for each repeat
  std::vector<Pair> pairs = {};
  std::vector<double> cycles = {};  ///< seconds, of the fastest repeat
  std::vector<double> totals = {};  ///< of each repeat: seconds of all cycles but the first
  double start = 0, bytes = 0;
  double instructions = 0;  ///< of the first repeat
  std::string note = {};
  double Mean() const {
    double sum = 0;
    for (const double cycle : cycles) sum += cycle;
    return sum / static_cast<double>(std::max<std::size_t>(1, cycles.size()));
  }
};

struct Settings {
  Options options;
  std::size_t cycles = 0, block = 20, repeats = 3;
  std::vector<std::string> scenes, only, libraries;
  bool walls = false, grows = false, counts = false;
};

/// Bodies up to which the pairs are checked, which takes longer than all detectors together.
constexpr std::size_t kMostChecked = 200000;
/// Seconds that one may take for a scene before it is left out.
double Patience() { return RUNNING_ON_VALGRIND ? 2000 : 20; }

std::vector<Competitor> MakeCompetitors(const Settings& settings, std::size_t bodies) {
  std::vector<Competitor> competitors;
  const auto add = [&](const std::string& name, bool is_builtin, const auto& make) {
    Competitor competitor;
    competitor.name = name;
    competitor.is_builtin = is_builtin;
    for (std::size_t repeat = 0; repeat < settings.repeats; ++repeat)
      competitor.detectors.push_back(make());
    competitor.totals.resize(settings.repeats);
    competitors.push_back(std::move(competitor));
  };
  const auto add_entry = [&](const detectors::LoadedDetector& entry, bool is_builtin) {
    const bool is_asked =
        settings.only.empty() || std::ranges::count(settings.only, entry.name) > 0;
    if (!is_asked || !HasAny(entry.phases, kBroad)) return;
    if (entry.max_bodies != 0 && bodies > entry.max_bodies) return;
    add(entry.name, is_builtin, [&] { return entry.make(settings.options); });
  };
  if (!settings.grows) {
    add("dbvt", false, [] { return std::make_unique<Dbvt>(false); });
    add("dbvt, listed", false, [] { return std::make_unique<Dbvt>(true); });
  }
  for (const DetectorEntry& entry : builtin::BuiltinDetectors())
    add_entry(detectors::LoadedDetector(entry), true);
  for (const std::string& path : settings.libraries) {
    const auto all = detectors::LoadPlugin(path);
    for (const detectors::LoadedDetector& loaded : all) add_entry(loaded, false);
  }
  return competitors;
}

/// The clock of all cycles, and its own time.
struct Timer {
  clockid_t clock;
  double own = ClockSeconds(clock);
  bool counts_instructions = false;  ///< each is taken for a nanosecond
};

void RunRepeat(Competitor& competitor, std::size_t repeat, Scene scene,
               std::span<const std::vector<Box>> frames, std::size_t first, const Timer& timer,
               InstructionCounter& counter) {
  Detector& detector = *competitor.detectors[repeat];
  std::size_t cycle = first;
  if (repeat == 0) counter.Begin();
  for (const std::vector<Box>& frame : frames) {
    scene.boxes = frame;
    competitor.pairs.clear();
    const bool is_first = cycle++ == 0;
    const bool counts = repeat == 0 && !is_first;
    if (counts) counter.Start();
    const double begin = Seconds(timer.clock);
    if (is_first) detector.Prepare(scene);
    detector.FindPairs(scene, competitor.pairs);
    double took = std::max(Seconds(timer.clock) - begin - timer.own, 1e-9);
    if (counts) counter.Stop();
    if (counts && timer.counts_instructions) {
      const double taken = counter.Take();
      competitor.instructions += taken;
      took = 1e-9 * taken;
    }
    if (is_first) {
      competitor.start = repeat == 0 ? took : std::min(competitor.start, took);
      continue;
    }
    competitor.totals[repeat] += took;
    const std::size_t place = cycle - 2;
    if (place == competitor.cycles.size())
      competitor.cycles.push_back(took);
    else
      competitor.cycles[place] = std::min(competitor.cycles[place], took);
  }
  if (repeat == 0) competitor.instructions += counter.Finish();
}

void RunBlock(Competitor& competitor, const Scene& scene, std::span<const std::vector<Box>> frames,
              std::size_t first, const Timer& timer, InstructionCounter& counter) {
  for (std::size_t repeat = 0; repeat < competitor.detectors.size(); ++repeat) {
    if (!competitor.note.empty()) return;
    const double heap = HeapBytes();
    try {
      RunRepeat(competitor, repeat, scene, frames, first, timer, counter);
    } catch (const std::exception& error) {
      competitor.note = error.what();
    }
    if (repeat == 0) competitor.bytes += HeapBytes() - heap;
    if (competitor.start + competitor.totals[repeat] > Patience()) competitor.note = "gave up";
  }
}

std::string WrongPairs(Competitor& competitor, const Scene& last) {
  if (competitor.name == "dbvt" || competitor.name == "null" || !competitor.note.empty()) return "";
  if (last.size > kMostChecked) return "not checked";
  const detectors::PairFaults faults = detectors::ComparePairs(last, std::move(competitor.pairs));
  if (faults.missed + faults.false_positives + faults.duplicate == 0) return "";
  return fmt::format("{} missed, {} false, {} twice", faults.missed, faults.false_positives,
                     faults.duplicate);
}

void PrintRow(Competitor& competitor, const Scene& last, double dbvt, double best) {
  if (competitor.cycles.empty()) competitor.cycles.push_back(competitor.start);
  const std::size_t pairs = competitor.pairs.size();
  const std::string wrong = WrongPairs(competitor, last);
  std::vector<double> cycles = competitor.cycles;
  std::ranges::sort(cycles);
  const double mean = competitor.Mean(), median = Median(cycles);
  const auto [least, most] = std::ranges::minmax(competitor.totals);
  fmt::print(
      "{:<17} {:>10.4f} {:>9.4f} {:>9.4f} {:>9.4f}{:>7.1f}{:>7.0f}% "
      "{:>9.3f}{:>9}{:>8.1f}{:>8.1f}{:>9.1f}  {}{}\n",
      competitor.name, 1e3 * mean, 1e3 * median, 1e3 * cycles[cycles.size() * 99 / 100],
      1e3 * cycles.back(), cycles.back() / median, least > 0 ? 100 * (most / least - 1) : 0,
      1e3 * competitor.start, pairs, dbvt / mean, best / mean, competitor.bytes / 1048576, wrong,
      competitor.note);
  std::fflush(stdout);
}

void PrintTable(std::vector<Competitor>& competitors, const Scene& last, const std::string& title) {
  double dbvt = 0, best = 0;
  std::string best_name;
  for (const Competitor& competitor : competitors) {
    if (!competitor.note.empty() || competitor.cycles.empty()) continue;
    if (competitor.name == "dbvt") dbvt = competitor.Mean();
    if (!competitor.is_builtin && (best_name.empty() || competitor.Mean() < best)) {
      best = competitor.Mean();
      best_name = competitor.name;
    }
  }
  fmt::print("\n{}{}\n", title, best_name.empty() ? "" : "; best third-party " + best_name);
  fmt::print("{:<17} {:>10} {:>9} {:>9} {:>9}{:>7}{:>8} {:>9}{:>9}{:>8}{:>8}{:>9}  {}\n", "",
             "mean ms", "p50", "p99", "worst", "w/p50", "spread", "start", "pairs", "/dbvt",
             "/best", "MiB", "wrong");
  for (Competitor& competitor : competitors) PrintRow(competitor, last, dbvt, best);
}

/// A detector's cost at one size.
struct GrowthPoint {
  std::string scene, name;
  double bodies, seconds, instructions, worst;  ///< seconds and instructions: of a cycle
};

void RunScene(const Settings& settings, std::string_view name, std::size_t objects,
              std::vector<GrowthPoint>& growth) {
  const bool is_elapsed = settings.options.threads > 1;
  Timer timer = {is_elapsed ? CLOCK_MONOTONIC : CLOCK_THREAD_CPUTIME_ID};
  timer.counts_instructions = settings.counts;
  InstructionCounter counter;
  // A box a frame is 48 bytes: no more than a block is kept.
  const std::size_t block = std::clamp<std::size_t>(4000000 / objects, 2, settings.block);
  const std::size_t usual = settings.grows ? std::clamp<std::size_t>(2000000 / objects, 8, 100)
                                           : std::clamp<std::size_t>(8000000 / objects, 8, 400);
  const std::size_t cycles = settings.cycles != 0 ? settings.cycles : usual;
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
    for (const std::size_t turn : turns)
      RunBlock(competitors[turn], moving.View(), frames, cycle, timer, counter);
  }
  for (const Competitor& competitor : competitors) {
    if (!competitor.note.empty() || competitor.cycles.empty() || competitor.name == "null")
      continue;
    growth.push_back({std::string(name), competitor.name, static_cast<double>(objects),
                      competitor.Mean(),
                      competitor.instructions / static_cast<double>(competitor.cycles.size()),
                      std::ranges::max(competitor.cycles)});
  }
  Scene last = moving.View();
  last.boxes = frames.back();
  PrintTable(competitors, last,
             fmt::format("{}, {} objects{}: {} cycles", name, objects,
                         settings.walls ? " and 6 walls" : "", cycles));
}

/// The slope of the line through the logarithms; "-" of one point, or of what was not counted.
std::string Exponent(const std::vector<const GrowthPoint*>& points, double GrowthPoint::*value) {
  double x = 0, y = 0, xx = 0, xy = 0;
  const auto n = static_cast<double>(points.size());
  for (const GrowthPoint* point : points) {
    const double a = std::log(point->bodies), b = std::log(point->*value);
    x += a;
    y += b;
    xx += a * a;
    xy += a * b;
  }
  const double slope = (n * xy - x * y) / (n * xx - x * x);
  return std::isfinite(slope) ? fmt::format("{:.2f}", slope) : "-";
}

void PrintGrowth(const std::vector<GrowthPoint>& growth) {
  fmt::print(
      "\nGrowth: exponents of processor time, instructions and the worst cycle; in brackets, for "
      "each body and cycle at each N, ns or, where counted, instructions\n");
  for (std::size_t i = 0; i < growth.size(); ++i) {
    const auto is_same = [&](const GrowthPoint& other) {
      return other.scene == growth[i].scene && other.name == growth[i].name;
    };
    if (std::find_if(growth.begin(), growth.end(), is_same) !=
        growth.begin() + static_cast<std::ptrdiff_t>(i))
      continue;
    std::vector<const GrowthPoint*> points;
    std::string costs;
    for (const GrowthPoint& point : growth) {
      if (!is_same(point)) continue;
      points.push_back(&point);
      costs += point.instructions > 0 ? fmt::format(" {:.0f}", point.instructions / point.bodies)
                                      : fmt::format(" {:.2f}", 1e9 * point.seconds / point.bodies);
    }
    fmt::print("{:<9}{:<19}{:>7}{:>7}{:>7}  ({} )\n", growth[i].scene, growth[i].name,
               Exponent(points, &GrowthPoint::seconds),
               Exponent(points, &GrowthPoint::instructions), Exponent(points, &GrowthPoint::worst),
               costs);
  }
}

int Main(int argc, char** argv) {
  Settings settings;
  std::string folder;
  for (int option; (option = getopt(argc, argv, "t:c:b:r:s:o:d:wgi")) != -1;) {
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
      case 'r':
        settings.repeats = static_cast<std::size_t>(std::max(1, std::atoi(optarg)));
        break;
      case 'g':
        settings.grows = true;
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
      case 'i':
        settings.counts = true;
        break;
      case 'w':
        settings.walls = true;
        break;
      default:
        return 2;
    }
  }
  if (settings.counts) settings.repeats = 1;
  if (!folder.empty())
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      if (entry.path().extension() == ".so") settings.libraries.push_back(entry.path());
  std::ranges::sort(settings.libraries);
  if (settings.scenes.empty())
    settings.scenes.assign(std::begin(tests::kBoxScenes), std::end(tests::kBoxScenes));
  std::vector<std::size_t> sizes;
  for (; optind < argc; ++optind)
    sizes.push_back(static_cast<std::size_t>(std::atof(argv[optind])));
  if (sizes.empty() && settings.grows) sizes = {1000, 10000, 100000, 1000000};
  if (sizes.empty()) sizes = {1000, 5000, 20000};
  std::vector<GrowthPoint> growth;
  for (const std::string& scene : settings.scenes)
    for (const std::size_t size : sizes) RunScene(settings, scene, size, growth);
  if (settings.grows) PrintGrowth(growth);
  return 0;
}

}  // namespace
}  // namespace cdb::bench

using namespace cdb;
using namespace cdb::bench;

int main(int argc, char** argv) { return Main(argc, argv); }
