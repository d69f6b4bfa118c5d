// Deforming meshes: the broad phases on the primitives of a sequence of meshes, and the exact tests
// of the pairs that they find.
//
// Times are processor time of the calling thread in ms, the least of the repeats, each with a new
// detector: `first` is Prepare and the first call, whose memory is new; `again` a second call on
// the same boxes, which finds everything anew, or shows that a detector keeps it; `next` the mean
// of the calls on later cycles, where a tree is refitted. `listed` counts all pairs of the first
// call, `missed` the exact pairs of boxes that are not among them. A table ends with the exact
// tests: how many pairs collide, how many the filter leaves to exact arithmetic, and the tests per
// second.
//
// Usage: bench_deforming [-r REPEATS] [-o NAME]... [-p PRIMITIVES]... [FOLDER | FRAME...]
// The frames are PLY, OBJ or OFF; of a folder, in the order of their names. Without any, a cloth of
// 150 x 150 vertices folds in six frames. -o: only these detectors; Bullet's `dbvt` and `sap32`
// only if they are named, as their set-up takes seconds.

#include <btBulletCollisionCommon.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <ctime>
#include <exception>
#include <filesystem>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "library/deforming/mesh_sequence.h"
#include "library/deforming/primitives.h"
#include "library/detectors/builtin/builtin.h"
#include "library/detectors/exact_pairs.h"
#include "tests/library/deforming/folding_cloth.h"

namespace cdb::bench {
namespace {

namespace fs = std::filesystem;
using deforming::Primitives;

double Milliseconds() {
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

template <typename Act>
double TimeOf(const Act& act) {
  const double begin = Milliseconds();
  act();
  return Milliseconds() - begin;
}

/// One of Bullet's, fed as its world does. Bodies are added shuffled, as rows of them degenerate
/// its tree. Coordinates are in single precision.
class BulletBroadPhase final : public Detector {
 public:
  explicit BulletBroadPhase(bool is_sweep) : is_sweep_(is_sweep) {}

  void Prepare(const Scene& scene) override {
    if (is_sweep_)
      broad_phase_ = std::make_unique<bt32BitAxisSweep3>(btVector3(-kFar, -kFar, -kFar),
                                                         btVector3(kFar, kFar, kFar),
                                                         static_cast<unsigned>(scene.size + 1));
    else
      broad_phase_ = std::make_unique<btDbvtBroadphase>();
    std::vector<Id> order(scene.size);
    for (Id id = 0; id < scene.size; ++id) order[id] = id;
    std::shuffle(order.begin(), order.end(), std::mt19937(1));
    proxies_.resize(scene.size);
    for (const Id id : order)
      proxies_[id] =
          broad_phase_->createProxy(Corner(scene.boxes[id].lower), Corner(scene.boxes[id].upper), 0,
                                    reinterpret_cast<void*>(static_cast<std::uintptr_t>(id)),
                                    static_cast<int>(scene.filters[id].group),
                                    static_cast<int>(scene.filters[id].mask), &dispatcher_);
  }
  void FindPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    for (Id id = 0; id < scene.size; ++id)
      broad_phase_->setAabb(proxies_[id], Corner(scene.boxes[id].lower),
                            Corner(scene.boxes[id].upper), &dispatcher_);
    broad_phase_->calculateOverlappingPairs(&dispatcher_);
    const auto& all = broad_phase_->getOverlappingPairCache()->getOverlappingPairArray();
    for (int i = 0; i < all.size(); ++i)
      pairs.push_back({IdOf(all[i].m_pProxy0), IdOf(all[i].m_pProxy1)});
  }

 private:
  static constexpr btScalar kFar = 1000;
  static Id IdOf(const btBroadphaseProxy* proxy) {
    return static_cast<Id>(reinterpret_cast<std::uintptr_t>(proxy->m_clientObject));
  }
  static btVector3 Corner(const Vec3& at) {
    return {static_cast<btScalar>(at.x), static_cast<btScalar>(at.y), static_cast<btScalar>(at.z)};
  }

  const bool is_sweep_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  std::unique_ptr<btBroadphaseInterface> broad_phase_;
  std::vector<btBroadphaseProxy*> proxies_;
};

std::unique_ptr<Detector> Make(const std::string& name) {
  if (name == "dbvt" || name == "sap32") return std::make_unique<BulletBroadPhase>(name != "dbvt");
  for (const DetectorEntry& entry : builtin::BuiltinDetectors())
    if (entry.name == name) return std::unique_ptr<Detector>(entry.make({}));
  throw std::runtime_error("there is no detector " + name);
}

/// The primitives of a sequence as a scene.
class Bodies {
 public:
  Bodies(Primitives primitives, const deforming::MeshSequence& sequence)
      : primitives_(primitives),
        sequence_(sequence),
        corners_(deforming::BodiesOf(primitives, sequence)),
        boxes_(corners_.size()) {
    for (const deforming::Corners& corners : corners_)
      filters_.push_back(deforming::FilterOf(primitives, corners));
    scene_.size = boxes_.size();
    scene_.boxes = boxes_;
    scene_.filters = filters_;
  }

  const Scene& At(std::size_t cycle) {
    deforming::FillBoxes(primitives_, sequence_, corners_, cycle, sides_);
    const double* side = sides_.data();
    for (Box& box : boxes_) {
      box = {{side[0], side[1], side[2]}, {side[3], side[4], side[5]}};
      side += 6;
    }
    return scene_;
  }
  std::size_t cycles() const { return deforming::CyclesOf(primitives_, sequence_); }
  bool IsAsked(const Pair& pair) const {
    return !deforming::AreNeighbours(corners_[pair.a], corners_[pair.b]);
  }
  bool Meet(const Pair& pair, std::size_t cycle) const {
    const std::size_t to = deforming::IsSwept(primitives_) ? cycle + 1 : cycle;
    return deforming::Meet(primitives_, corners_[pair.a], corners_[pair.b], sequence_.frames[cycle],
                           sequence_.frames[to]);
  }

 private:
  const Primitives primitives_;
  const deforming::MeshSequence& sequence_;
  const std::vector<deforming::Corners> corners_;
  std::vector<Box> boxes_;
  std::vector<Filter> filters_;
  std::vector<double> sides_;
  Scene scene_;
};

struct Times {
  static constexpr double kNone = std::numeric_limits<double>::infinity();
  double first = kNone, again = kNone, next = kNone;
};

void PrintTable(Primitives primitives, const deforming::MeshSequence& sequence,
                const std::vector<std::string>& names, int repeats) {
  Bodies bodies(primitives, sequence);
  const auto asked = [&](const Pair& pair) { return bodies.IsAsked(pair); };
  const std::vector<Pair> exact = detectors::ExactPairs(bodies.At(0), asked);
  fmt::print("\n{}: {} bodies, {} cycles, {} pairs in the first\n", deforming::WordOf(primitives),
             bodies.At(0).size, bodies.cycles(), exact.size());
  fmt::print("{:<18}{:>10}{:>10}{:>10}{:>12}{:>10}\n", "", "first", "again", "next", "listed",
             "missed");
  for (const std::string& name : names) {
    Times times;
    std::size_t listed = 0, missed = 0;
    for (int repeat = 0; repeat < repeats; ++repeat) {
      const auto detector = Make(name);
      std::vector<Pair> pairs;
      const Scene& scene = bodies.At(0);
      const auto find = [&] {
        pairs.clear();
        detector->FindPairs(scene, pairs);
      };
      times.first = std::min(times.first, TimeOf([&] {
                               detector->Prepare(scene);
                               find();
                             }));
      times.again = std::min(times.again, TimeOf(find));
      if (repeat == 0) {
        listed = pairs.size();
        for (Pair& pair : pairs)
          if (pair.a > pair.b) std::swap(pair.a, pair.b);
        missed = detectors::ComparePairs(scene, pairs, asked).missed;
      }
      double sum = 0;
      for (std::size_t cycle = 1; cycle < bodies.cycles(); ++cycle) {
        bodies.At(cycle);
        sum += TimeOf(find);
      }
      if (bodies.cycles() > 1)
        times.next = std::min(times.next, sum / static_cast<double>(bodies.cycles() - 1));
    }
    fmt::print("{:<18}{:>10.1f}{:>10.1f}{:>10}{:>12}{:>10}\n", name, times.first, times.again,
               bodies.cycles() > 1 ? fmt::format("{:.1f}", times.next) : "-", listed, missed);
  }
  std::size_t tests = 0, collisions = 0;
  double time = 0;
  for (std::size_t cycle = 0; cycle < bodies.cycles(); ++cycle) {
    const auto pairs = cycle == 0 ? exact : detectors::ExactPairs(bodies.At(cycle), asked);
    tests += pairs.size();
    time += TimeOf([&] {
      for (const Pair& pair : pairs) collisions += bodies.Meet(pair, cycle);
    });
  }
  fmt::print(
      "exact tests of all cycles: {} collisions of {} pairs, {:.1f} ms, {:.2f} million a second\n",
      collisions, tests, time, static_cast<double>(tests) / time / 1e3);
}

std::vector<fs::path> FramesOf(char** begin, char** end) {
  std::vector<fs::path> frames(begin, end);
  if (frames.size() != 1 || !fs::is_directory(frames[0])) return frames;
  const fs::path folder = frames[0];
  frames.clear();
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file()) frames.push_back(entry.path());
  std::ranges::sort(frames);
  return frames;
}

int Main(int argc, char** argv) {
  std::vector<std::string> names, words;
  int repeats = 3;
  for (int option; (option = getopt(argc, argv, "r:o:p:")) != -1;) {
    if (option == 'r')
      repeats = std::max(1, std::atoi(optarg));
    else if (option == 'o')
      names.emplace_back(optarg);
    else if (option == 'p')
      words.emplace_back(optarg);
    else
      return 2;
  }
  if (names.empty())
    for (const DetectorEntry& entry : builtin::BuiltinDetectors())
      if (HasAny(entry.phases, kBroad)) names.emplace_back(entry.name);
  if (words.empty()) words = {"triangles", "vertex_face", "edge_edge"};
  const std::vector<fs::path> frames = FramesOf(argv + optind, argv + argc);
  constexpr std::uint32_t kSide = 151;  // odd
  constexpr std::size_t kFrames = 6;
  const deforming::MeshSequence sequence =
      frames.empty() ? tests::FoldingCloth(kSide, kFrames) : deforming::ReadSequence(frames);
  fmt::print("{} vertices, {} triangles, {} frames\n", sequence.vertices(),
             sequence.triangles.size(), sequence.frames.size());
  for (const std::string& word : words) {
    const auto primitives = deforming::PrimitivesOf(word);
    if (!primitives) throw std::runtime_error(word + " is none of " + deforming::PrimitiveWords());
    PrintTable(*primitives, sequence, names, repeats);
  }
  return 0;
}

}  // namespace
}  // namespace cdb::bench

int main(int argc, char** argv) try {
  return cdb::bench::Main(argc, argv);
} catch (const std::exception& error) {
  fmt::print(stderr, "bench_deforming: {}\n", error.what());
  return 1;
}
