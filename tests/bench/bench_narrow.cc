// Narrow phases on pairs of two bodies of about 1 m: ns per pair, apart by 0.02 m, and overlapping
// by 0.01 and 0.10 m. All in one process, in turn, cycle by cycle; medians, and the spread from the
// first to the third quartile. With coherence, the bodies turn by about a thousandth of a radian a
// cycle, as they do while they touch; without, each cycle has other pairs.
//
// `bullet` is the algorithm that Bullet has for the pair, kept from cycle to cycle, with its
// manifolds; the others are called through the interface of detectors.
//
// Usage: bench_narrow_f32 [-n PAIRS] [-c CYCLES] [-t TYPE-TYPE] [-i] [-d FOLDER WITH SHARED
// LIBRARIES] -t: only these types, e.g. box-box. -i: instructions in place of time
// (tests/bench/instructions.h).
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

void PrintErrors(tests::Type a, tests::Type b, int count, const Library& library) {
  distributions::Stream stream(5);
  std::vector<PairCase> cases;
  std::vector<tests::ExactContact> exact;
  for (int i = 0; i < count; ++i) {
    cases.push_back(tests::RandomPair(stream, a, b));
    exact.push_back(tests::ExactOf(cases.back()));
  }
  for (Competitor& one : MakeCompetitors(cases, true, library)) {
    const tests::Faults faults = tests::Judge(*one.detector, cases, exact);
    if (faults.pairs == 0) continue;
    fmt::print("{:<24} {:<8} {:>7} {:>7} {:>6} {:>6} {:>7}  {:>7.1e} {:>7.1e}  {:>7.1e} {:>7.1e}\n",
               fmt::format("{}-{}", NameOf(a), NameOf(b)), one.name, faults.overlaps, faults.missed,
               faults.near, faults.missed_near, faults.phantom, faults.mean_depth,
               faults.worst_depth, faults.mean_normal, faults.worst_normal);
  }
}

void PrintAllErrors(int count, const Library& library) {
  fmt::print("{:<24} {:<8} {:>7} {:>7} {:>6} {:>6} {:>7}  {:>15}  {:>15}\n", "types", "by",
             "overlap", "missed", "near", "missed", "phantom", "depth, mean max", "normal, rad");
  using enum tests::Type;
  constexpr tests::Type kTypes[] = {kBall, kCapsule, kBox, kTetrahedron, kHull, kCompound, kPlane};
  for (const tests::Type* a = std::begin(kTypes); *a != kPlane; ++a)
    for (const tests::Type* b = a; b != std::end(kTypes); ++b) PrintErrors(*a, *b, count, library);
}

int Main(int argc, char** argv) {
  Settings settings;
  std::string folder = "build/detectors";
  int errors = 0;
  for (int option; (option = getopt(argc, argv, "n:c:t:d:e:i")) != -1;) {
    if (option == 'n') settings.pairs = std::strtoul(optarg, nullptr, 10);
    if (option == 'c') settings.cycles = std::atoi(optarg);
    if (option == 't') settings.only = optarg;
    if (option == 'd') folder = optarg;
    if (option == 'i') settings.counts = true;
    if (option == 'e') errors = std::atoi(optarg);
    if (option == '?') return 2;
  }
  if (errors > 0) {
    PrintAllErrors(errors, Library(folder));
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
