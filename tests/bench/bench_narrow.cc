// Narrow phases on pairs of two bodies of about 1 m: ns per pair, apart by 0.02 m, and overlapping
// by 0.01 and 0.10 m. All in one process, in turn, cycle by cycle; medians, and the spread from the
// first to the third quartile. With coherence, the bodies turn by about a thousandth of a radian a
// cycle, as they do while they touch; without, each cycle has other pairs.
//
// `bullet` is the algorithm that Bullet has for the pair, kept from cycle to cycle, with its
// manifolds; the others are called through the interface of detectors.
//
// With -e N: the errors of all of them on N random poses of each pair of types, from deep to just
// apart, thin, tiny, huge and parallel ones among them, against exact contacts
// (library/exact/signed_distance.h); and where another is better than `batch`.
//
// Usage: bench_narrow_f32 [-n PAIRS] [-c CYCLES] [-t TYPE-TYPE] [-i] [-d FOLDER WITH SHARED
// LIBRARIES], bench_narrow_f64 -e POSES [-b] [-t TYPE-TYPE] [-d …]. -t: only these types, e.g.
// box-box. -b: only `batch`. -i: instructions in place of time (tests/bench/instructions.h).
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

#include "library/detectors/narrow/batch.h"
#include "library/detectors/plugin.h"
#include "tests/bench/bullet_pairs.h"
#include "tests/bench/instructions.h"
#include "tests/bench/median.h"
#include "tests/library/detectors/narrow/pair_cases.h"
#include "tests/library/objects/random_solids.h"

namespace cdb::bench {
namespace {

using tests::PairCase;

double Now() {
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e9 + static_cast<double>(time.tv_nsec);
}

struct Row {
  const char* name;
  tests::Type a, b;
  std::size_t vertices = 0;  ///< of hulls
};
constexpr Row kRows[] = {
    {"ball-ball", tests::Type::kBall, tests::Type::kBall},
    {"ball-capsule", tests::Type::kBall, tests::Type::kCapsule},
    {"capsule-capsule", tests::Type::kCapsule, tests::Type::kCapsule},
    {"ball-box", tests::Type::kBall, tests::Type::kBox},
    {"capsule-box", tests::Type::kCapsule, tests::Type::kBox},
    {"box-box", tests::Type::kBox, tests::Type::kBox},
    {"box-plane", tests::Type::kBox, tests::Type::kPlane},
    {"cylinder-plane", tests::Type::kCylinder, tests::Type::kPlane},
    {"ball-cylinder", tests::Type::kBall, tests::Type::kCylinder},
    {"capsule-cylinder", tests::Type::kCapsule, tests::Type::kCylinder},
    {"box-cylinder", tests::Type::kBox, tests::Type::kCylinder},
    {"box-cone", tests::Type::kBox, tests::Type::kCone},
    {"tetrahedron-cylinder", tests::Type::kTetrahedron, tests::Type::kCylinder},
    {"cylinder-cylinder", tests::Type::kCylinder, tests::Type::kCylinder},
    {"cylinder-cone", tests::Type::kCylinder, tests::Type::kCone},
    {"cone-cone", tests::Type::kCone, tests::Type::kCone},
    {"ellipsoid-ellipsoid", tests::Type::kEllipsoid, tests::Type::kEllipsoid},
    {"ball-hull16", tests::Type::kBall, tests::Type::kHull, 16},
    {"box-hull16", tests::Type::kBox, tests::Type::kHull, 16},
    {"hull16-hull16", tests::Type::kHull, tests::Type::kHull, 16},
    {"hull32-hull32", tests::Type::kHull, tests::Type::kHull, 32},
};
constexpr double kGaps[] = {0.022, -0.01, -0.10};

std::vector<PairCase> MakeCases(const Row& row, double gap, std::size_t count) {
  distributions::Stream stream(3);
  std::vector<PairCase> cases;
  const auto make = [&](tests::Type type) {
    return type == tests::Type::kHull ? tests::RoundHull(row.vertices, 1)
                                      : tests::RandomBody(stream, type, 1, false);
  };
  while (cases.size() < count) {
    PairCase pair{make(row.a), make(row.b), {}, {}, row.b == tests::Type::kPlane};
    pair.pose_a = {10 * tests::RandomDirection(stream), stream.Turn()};
    pair.pose_b = {pair.pose_a.position + 1.5 * tests::RandomDirection(stream), stream.Turn()};
    for (int i = 0; i < 4; ++i) tests::MoveToGap(pair, gap);
    cases.push_back(std::move(pair));
  }
  return cases;
}

/// A competitor and its times.
struct Competitor {
  std::string name;
  std::unique_ptr<Detector> detector, forgetful = nullptr;  ///< the second sees other pairs between
  BulletPairs* bullet = nullptr;
  std::vector<Contact> contacts = {};
  std::vector<double> coherent = {}, cold = {};
};

class Library {
 public:
  explicit Library(std::string folder) : folder_(std::move(folder)) {}
  std::unique_ptr<Detector> Make(const char* part, const char* name) const {
    const std::string file = fmt::format("{}/cdb-detectors-{}.so", folder_, part);
    if (access(file.c_str(), R_OK) != 0) return nullptr;
    const auto all = detectors::LoadPlugin(file);
    return detectors::FindDetector(all, name)->make({});
  }

 private:
  std::string folder_;
};

std::vector<Competitor> MakeCompetitors(const std::vector<PairCase>& cases, bool copies,
                                        const Library& library) {
  std::vector<Competitor> all;
  auto bullet = std::make_unique<BulletPairs>(cases, copies);
  BulletPairs* const place = bullet.get();
  all.push_back({.name = "bullet", .detector = std::move(bullet), .bullet = place});
  all.push_back({.name = "batch",
                 .detector = std::unique_ptr<Detector>(narrow::MakeBatch({})),
                 .forgetful = std::unique_ptr<Detector>(narrow::MakeBatch({}))});
  for (const auto& [part, name] :
       {std::pair{"ccd", "ccd_mpr"}, std::pair{"ccd", "ccd_gjk"}, std::pair{"fcl", "fcl_gjk"}})
    if (auto detector = library.Make(part, name))
      all.push_back({.name = name, .detector = std::move(detector)});
  return all;
}

double Quantile(std::vector<double> values, double part) {
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1))];
}

/// Turns the bodies a little, to and fro.
std::vector<Pose> Turned(std::span<const Pose> poses, int cycle) {
  std::vector<Pose> turned(poses.begin(), poses.end());
  const double angle = 1e-3 * std::sin(cycle), cosine = std::cos(angle), sine = std::sin(angle);
  for (std::size_t i = 0; i < turned.size(); i += 2) {
    Pose& pose = turned[i];
    const Vec3 x = pose.x, y = pose.y;
    pose.x = {cosine * x.x + sine * y.x, cosine * x.y + sine * y.y, cosine * x.z + sine * y.z};
    pose.y = {cosine * y.x - sine * x.x, cosine * y.y - sine * x.y, cosine * y.z - sine * x.z};
  }
  return turned;
}

double TimeOf(Competitor& competitor, const Scene& scene, std::span<const Pair> pairs) {
  competitor.contacts.clear();
  const double begin = Now();
  competitor.detector->FindContacts(scene, pairs, competitor.contacts);
  return (Now() - begin) / static_cast<double>(pairs.size());
}

struct Settings {
  std::size_t pairs = 256;
  int cycles = 60;
  std::string only;
  bool counts = false;
};

void RunRow(const Row& row, double gap, const Settings& settings, const Library& library) {
  const std::vector<PairCase> cases = MakeCases(row, gap, 2 * settings.pairs);
  const tests::PairScene bodies(cases);
  Scene scene = bodies.View();
  const std::span all = bodies.pairs();
  // Of the two halves one is used in all cycles; for cold ones, they take turns.
  const auto first = all.first(settings.pairs), second = all.subspan(settings.pairs);
  std::vector<Competitor> competitors = MakeCompetitors(cases, false, library);
  for (Competitor& competitor : competitors) {
    competitor.detector->Prepare(scene);
    if (competitor.forgetful != nullptr) competitor.forgetful->Prepare(scene);
  }
  std::erase_if(competitors, [&](const Competitor& one) {
    return one.bullet == nullptr && !one.detector->Handles(scene, 0, 1);
  });
  InstructionCounter counter;
  if (settings.counts) counter.Begin();
  for (int cycle = 0; cycle < settings.cycles; ++cycle) {
    const std::vector<Pose> poses = Turned(bodies.View().poses, cycle);
    scene.poses = poses;
    for (std::size_t k = 0; k < competitors.size(); ++k) {
      Competitor& one = competitors[(k + static_cast<std::size_t>(cycle)) % competitors.size()];
      if (one.bullet != nullptr) one.bullet->Place(scene);
      if (cycle > 1 && settings.counts) counter.Start();
      const double time = TimeOf(one, scene, first);
      if (cycle > 1 && settings.counts) {
        counter.Stop();
        one.coherent.push_back(counter.Take() / static_cast<double>(first.size()));
      } else if (cycle > 1) {
        one.coherent.push_back(time);
      }
      if (cycle <= 1) continue;
      if (one.forgetful == nullptr) continue;
      std::swap(one.detector, one.forgetful);
      TimeOf(one, scene, second);
      one.cold.push_back(TimeOf(one, scene, first));
      std::swap(one.detector, one.forgetful);
    }
  }
  for (const Competitor& one : competitors)
    fmt::print("{:<16} {:>6.2f}  {:<8} {:>8.1f} ({:>7.1f} .. {:>7.1f}) {:>8}\n", row.name, gap,
               one.name, Median(one.coherent), Quantile(one.coherent, 0.25),
               Quantile(one.coherent, 0.75),
               one.cold.empty() ? "-" : fmt::format("{:.1f}", Median(one.cold)));
}

/// Errors of one competitor on pairs of two types.
struct Errors {
  std::string name;
  tests::Faults faults, of_batch;  ///< the second on the same pairs
};

/// What is compared: the smaller, the better.
struct Measure {
  const char* name;
  double (*of)(const tests::Faults& faults);
  /// Numbers that differ by less are equal: a millionth of a size and a microradian are rounding
  /// errors of a run in single precision.
  double slop;
};
constexpr Measure kMeasures[] = {
    {"missed overlaps", [](const tests::Faults& faults) { return 1. * faults.missed; }, 0},
    {"phantom overlaps", [](const tests::Faults& faults) { return 1. * faults.phantom; }, 0},
    {"median depth", [](const tests::Faults& f) { return tests::Quantile(f.depths, 0.5); }, 1e-6},
    {"99 % depth", [](const tests::Faults& f) { return tests::Quantile(f.depths, 0.99); }, 1e-6},
    {"worst depth", [](const tests::Faults& faults) { return faults.worst_depth; }, 1e-6},
    {"median normal", [](const tests::Faults& f) { return tests::Quantile(f.normals, 0.5); }, 1e-6},
    {"99 % normal", [](const tests::Faults& f) { return tests::Quantile(f.normals, 0.99); }, 1e-6},
    {"worst normal", [](const tests::Faults& faults) { return faults.worst_normal; }, 1e-6},
    {"99 % place", [](const tests::Faults& f) { return tests::Quantile(f.surfaces, 0.99); }, 1e-6},
    {"worst place", [](const tests::Faults& faults) { return faults.worst_surface; }, 1e-6},
};

void PrintRow(const std::string& types, const std::string& name, const tests::Faults& faults) {
  const auto three = [](const std::vector<double>& values, double worst) {
    return fmt::format("{:>7.0e}{:>7.0e}{:>7.0e}", tests::Quantile(values, 0.5),
                       tests::Quantile(values, 0.99), worst);
  };
  fmt::print("{:<24} {:<8} {:>7} {:>7} {:>6} {:>7}  {}  {}  {}\n", types, name, faults.pairs,
             faults.overlaps, faults.missed, faults.phantom,
             three(faults.depths, faults.worst_depth), three(faults.normals, faults.worst_normal),
             three(faults.surfaces, faults.worst_surface));
  if (faults.missed + faults.phantom > 0 && name == "batch")
    fmt::print("  the pose {} is one of them\n", faults.worst_pair);
  std::fflush(stdout);
}

/// Random pairs of two types, with their exact contacts.
struct Poses {
  std::vector<PairCase> cases;
  std::vector<tests::ExactContact> exact;
};
Poses RandomPoses(distributions::Stream& stream, tests::Type a, tests::Type b, int count) {
  Poses made;
  for (int i = 0; i < count; ++i) {
    made.cases.push_back(tests::RandomPair(stream, a, b));
    made.exact.push_back(tests::ExactOf(made.cases.back()));
  }
  return made;
}

/// Poses at a time: a million with their shapes would not fit into memory.
constexpr int kChunk = 2000;

struct ErrorSettings {
  int count = 0;            ///< poses of each pair of types; 0: no errors
  bool only_batch = false;  ///< without competitors
  /// The distance from a surface takes long: it is judged for at most 20,000 poses.
  int Every() const { return std::max(5, count / 20000); }
};

/// Prints the errors of all competitors, and adds to `behind` where one is better than `batch`.
void PrintErrors(tests::Type a, tests::Type b, const ErrorSettings& settings,
                 const Library& library, std::vector<std::string>& behind) {
  distributions::Stream stream(5);
  const std::string types = fmt::format("{}-{}", NameOf(a), NameOf(b));
  std::vector<Errors> found;
  for (int first = 0; first < settings.count; first += kChunk) {
    const Poses poses = RandomPoses(stream, a, b, std::min(kChunk, settings.count - first));
    std::vector<Competitor> all = MakeCompetitors(poses.cases, true, library);
    if (settings.only_batch)
      std::erase_if(all, [](const Competitor& one) { return one.name != "batch"; });
    Detector& batch = *std::ranges::find(all, "batch", &Competitor::name)->detector;
    const auto judge = [&](Detector& detector, const Detector* other, tests::Faults& faults) {
      faults.Add(tests::Judge(detector, poses.cases, poses.exact, other, settings.Every()), first);
    };
    found.resize(all.size());
    for (std::size_t k = 0; k < all.size(); ++k) {
      found[k].name = all[k].name;
      judge(*all[k].detector, nullptr, found[k].faults);
      if (all[k].detector.get() != &batch) judge(batch, all[k].detector.get(), found[k].of_batch);
    }
  }
  for (const Errors& one : found) {
    if (one.faults.pairs == 0) continue;
    PrintRow(types, one.name, one.faults);
    if (one.name == "batch") continue;
    for (const Measure& measure : kMeasures)
      if (const double own = measure.of(one.of_batch), other = measure.of(one.faults);
          own > other + measure.slop)
        behind.push_back(fmt::format("{:<24} {:<17} batch {:>8.1e}, {} {:>8.1e}", types,
                                     measure.name, own, one.name, other));
  }
}

void PrintAllErrors(const ErrorSettings& settings, const std::string& only,
                    const Library& library) {
  fmt::print(
      "{} poses of each pair of types, in double precision. Errors of the deepest point: "
      "depth in sizes of the smaller body; normal, rad; distance of points from the surface, "
      "in sizes. Of the pairs that each handles; each median, 99 %, worst\n",
      settings.count);
  fmt::print("{:<24} {:<8} {:>7} {:>7} {:>6} {:>7}  {:>21}  {:>21}  {:>21}\n", "types", "by",
             "pairs", "overlap", "missed", "phantom", "depth", "normal", "place");
  std::vector<std::string> behind;
  for (int i = 0; i < static_cast<int>(tests::Type::kPlane); ++i)
    for (int j = i; j <= static_cast<int>(tests::Type::kPlane); ++j) {
      const auto a = static_cast<tests::Type>(i), b = static_cast<tests::Type>(j);
      if (only.empty() || only == fmt::format("{}-{}", NameOf(a), NameOf(b)))
        PrintErrors(a, b, settings, library, behind);
    }
  fmt::print("\n{}\n", behind.empty() ? "batch is nowhere behind another by more than 1e-6"
                                      : "batch is behind, on the pairs that both handle:");
  for (const std::string& line : behind) fmt::print("  {}\n", line);
}

int Main(int argc, char** argv) {
  Settings settings;
  std::string folder = "build/detectors";
  ErrorSettings errors;
  for (int option; (option = getopt(argc, argv, "n:c:t:d:e:ib")) != -1;) {
    if (option == 'n') settings.pairs = std::strtoul(optarg, nullptr, 10);
    if (option == 'c') settings.cycles = std::atoi(optarg);
    if (option == 't') settings.only = optarg;
    if (option == 'd') folder = optarg;
    if (option == 'i') settings.counts = true;
    if (option == 'e') errors.count = std::atoi(optarg);
    if (option == 'b') errors.only_batch = true;
    if (option == '?') return 2;
  }
  if (errors.count > 0) {
    PrintAllErrors(errors, settings.only, Library(folder));
    return 0;
  }
  fmt::print("{} pairs; {} a pair, medians (quartiles)\n", settings.pairs,
             settings.counts ? "instructions" : "ns");
  fmt::print("{:<16} {:>6}  {:<8} {:>8} {:>20} {:>8}\n", "types", "gap, m", "by", "coherent", "",
             "cold");
  const Library library(folder);
  for (const Row& row : kRows) {
    if (!settings.only.empty() && settings.only != row.name) continue;
    for (const double gap : kGaps) RunRow(row, gap, settings, library);
  }
  return 0;
}

}  // namespace
}  // namespace cdb::bench

int main(int argc, char** argv) { return cdb::bench::Main(argc, argv); }
