// The formulae behind the table of lints.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "compiler/checks/bounds.h"
#include "compiler/checks/lints.h"
#include "compiler/plan/expectation.h"
#include "compiler/schema/parametrised_words.h"

namespace cdb::checks {
namespace {

using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Walls that are boxes are so thick, in sides of the cube (runtime/needs/needs.h).
constexpr double kWallThickness = 0.1;

// Thresholds, measured.
constexpr double kTallStack = 0.025, kMassRatio = 12, kHeavyEndLimit = 0.1, kNarrowFoot = 30,
                 kOverlap = 0.3;
constexpr double kLongStepOnPlane = 0.04, kLongStepOnBox = 0.3;
constexpr double kThinWall = 1.5, kSoftContact = 0.04, kStiffSpring = 2, kThinShape = 30;
constexpr double kFastSpin = 1.41, kSpinDrift = 0.05;
constexpr double kHugeBox = 1e6, kCoarsePlace = 0.012, kLostMotion = 0.4;
/// Bullet puts to sleep what has been slower than these for so long, s.
constexpr double kSlowSpeed = 0.8, kSlowSpin = 1, kSleepAfter = 2;
/// A pyramid is as unsteady as a stack of so much of its height.
constexpr double kPyramid = 0.4;
/// Gravity is lost where it gives less than half a step, motion is wrong long before.
constexpr double kGainOverPlace = 0.2;
constexpr double kHopelesslyCoarse = 0.5;
constexpr double kRounding = 1e-9;
/// Sides that an object has to move for its motion to count.
constexpr double kNoticed = 0.01;
constexpr double kFastHit = 2, kShortRun = 35;
constexpr double kHeavySingle = 1.45e7, kHeavyDouble = 7e15;

/// The objects of one group by the bounds of what they draw. SI units.
struct Objects {
  const plan::GroupSettings* settings = nullptr;
  std::size_t index = 0;
  double quantity = 0;
  Vector3d least_sides, most_sides;
  double least_side = 0, longest_side = 0;  ///< of any object
  bool moves = false;
  Bounds mass;
  Vector3d velocity;  ///< largest components
  double speed = 0, spin = 0;
  Vector3d place;      ///< largest coordinates at the start
  double stacked = 1;  ///< objects on one another
  double tower = 1;    ///< as unsteady as a stack of so many
  double load = 1;     ///< mass of the end of a chain over that of the others
  bool linked = false, springs = false;
  double overlap = 0;  ///< m, of neighbours at the start
  double gap = 0;      ///< that a stack's objects fall by first; 0 where it is next to none
};

bool MayBe(const schema::Value& value, std::string_view word) {
  if (const auto* one = std::get_if<schema::Word>(&value)) return one->text == word;
  const auto* drawn = std::get_if<schema::Distribution>(&value);
  return drawn != nullptr &&
         std::ranges::any_of(drawn->arguments,
                             [&](const schema::Value& choice) { return MayBe(choice, word); });
}

class SceneNumbers {
 public:
  explicit SceneNumbers(const plan::Scene& scene)
      : world_(scene.world),
        timestep_(world_.Real("timestep")),
        iterations_(static_cast<double>(world_.Count("solver.iterations"))),
        cycles_(static_cast<double>(world_.Count("cycles") + world_.Count("warmup"))),
        rests_(plan::ExpectationOf(scene) == plan::Expectation::kRest),
        side_(world_.Real("world.side")),
        pull_(LargestComponents(world_.Get("acceleration"))),
        g_(pull_.norm()),
        walls_(world_.WordOr("world.walls")),
        box_walls_(walls_ != "none" && world_.WordOr("world.wall_shape") == "box"),
        single_(world_.WordOr("precision") == "single"),
        epsilon_(single_ ? std::numeric_limits<float>::epsilon()
                         : std::numeric_limits<double>::epsilon()) {
    groups_.reserve(scene.groups.size());
    for (std::size_t i = 0; i < scene.groups.size(); ++i)
      if (scene.groups[i].settings.Count("quantity") > 0) AddGroup(scene.groups[i].settings, i);
    for (const Objects& objects : groups_) count_ += objects.quantity;
    has_ground_ =
        walls_ != "none" || std::ranges::any_of(groups_, [](const Objects& o) { return !o.moves; });
  }

  std::vector<LintNumber> All() {
    for (const Objects& objects : groups_) {
      if (!objects.moves) continue;
      if (g_ > 0 && has_ground_) {
        TallStack(objects);
        LongStep(objects);
        SoftContact(objects);
        if (rests_) ShortRun(objects);
      }
      if (box_walls_) ThinWall(objects);
      if (walls_ != "none" || count_ > 1) FastHit(objects);
      EarlySleep(objects);
      if (objects.springs) StiffSpring(objects);
      if (!objects.linked && objects.quantity > 1)
        Add(Lint::kOverlap, objects, objects.overlap / objects.least_side, kOverlap,
            [&](double excess) { return objects.overlap / excess; });
      FastSpin(objects);
      if (!objects.linked) SpinDrift(objects);
      HugeBox(objects);
      if (!objects.linked) LostMotion(objects);
      if (MayTouch()) {
        ThinShape(objects);
        CoarsePlace(objects);
        HeavyMass(objects);
      }
    }
    if (g_ > 0 && has_ground_) MassRatio();
    if (g_ > 0) HeavyEnd();
    if (g_ > 0 && rests_) NarrowFoot();
    std::ranges::sort(numbers_, {}, &LintNumber::lint);
    return std::move(numbers_);
  }

 private:
  void AddGroup(const plan::GroupSettings& settings, std::size_t index) {
    Objects objects;
    objects.settings = &settings;
    objects.index = index;
    objects.quantity = static_cast<double>(settings.Count("quantity"));
    const Bounds size = PositiveBounds(settings.Get("size"));
    const Vector3d& aspect = std::get<schema::Ratio>(settings.Get("aspect")).parts;
    objects.least_sides = size.least * aspect;
    objects.most_sides = size.most * aspect;
    objects.least_side = objects.least_sides.minCoeff();
    objects.longest_side = objects.most_sides.maxCoeff();
    objects.mass = PositiveBounds(settings.Get("mass"));
    objects.moves = objects.mass.most > 0;
    objects.velocity = LargestComponents(settings.Get("linear_velocity"));
    objects.speed = objects.velocity.norm();
    objects.spin = LargestComponents(settings.Get("angular_velocity")).norm();
    objects.linked = settings.WordOr("links.type") != "none";
    objects.springs = settings.WordOr("links.type") == "spring";
    const auto* end_mass = std::get_if<double>(&settings.Get("links.end_mass"));
    if (objects.linked && end_mass != nullptr) {
      objects.load = *end_mass / objects.mass.least;
      objects.mass.least = std::min(objects.mass.least, *end_mass);
    }
    Locate(objects);
    groups_.push_back(objects);
  }

  void Locate(Objects& objects) const {
    objects.place = Vector3d::Constant(side_ / 2);
    const schema::Call* layout = schema::AsCall(objects.settings->Get("location"));
    if (layout == nullptr) return;
    const auto real = [&](std::string_view argument) {
      const auto* given = std::get_if<double>(&schema::ArgumentOf(*layout, argument));
      return given != nullptr ? std::optional<double>(*given) : std::nullopt;
    };
    if (layout->name == "at") {
      objects.place = Vector3d(*real("x"), *real("y"), *real("z")).cwiseAbs();
    } else if (layout->name == "pair") {
      objects.place = Vector3d::Constant(objects.longest_side + *real("distance"));
    } else if (layout->name == "line") {
      objects.overlap = std::max(0.0, -real("gap").value_or(0));
    } else if (layout->name == "stack") {
      const auto* height = std::get_if<std::uint64_t>(&schema::ArgumentOf(*layout, "height"));
      objects.stacked = height != nullptr ? std::min(objects.quantity, static_cast<double>(*height))
                                          : objects.quantity;
      objects.tower = objects.stacked;
      objects.gap = real("gap").value_or(0);
    } else if (layout->name == "pyramid") {
      while (objects.stacked * (objects.stacked + 1) * (2 * objects.stacked + 1) / 6 <
             objects.quantity)
        ++objects.stacked;
      objects.tower = kPyramid * objects.stacked;
      objects.gap = real("gap").value_or(0);
    }
  }

  bool MayTouch() const { return walls_ != "none" || count_ > 1; }

  double Time() const { return timestep_ * cycles_; }

  /// The fastest that an object gets: by falling too, as far as there is to fall.
  double FastestSpeed(const Objects& objects) const {
    if (walls_ == "none") return objects.speed + Fallen(objects);
    return std::hypot(objects.speed, Fallen(objects));
  }

  /// The speed that falling gives, as far as there is to fall.
  double Fallen(const Objects& objects) const {
    if (rests_) return 0;
    // What hangs swings at most from above its anchor to below.
    if (objects.linked && objects.settings->On("links.anchor"))
      return std::min(g_ * Time(), std::sqrt(8 * g_ * objects.quantity * objects.longest_side));
    const double fallen = g_ * Time();
    return walls_ == "none" ? fallen : std::min(std::sqrt(2 * g_ * side_), fallen);
  }

  /// Just below where warnings begin: what remedies aim at.
  static double Harmless(double threshold) { return threshold * LintNumber::kDoubtful * 0.999; }

  /// `remedy` is the parameter with which the number would be harmless, a function of how often the
  /// number is too large.
  template <typename Remedy>
  void Add(Lint lint, const Objects& objects, double value, double threshold, Remedy remedy,
           bool open = false) {
    if (!(value > 0)) return;
    const LintNumber number{
        lint, value, threshold, objects.index, remedy(value / Harmless(threshold)), open};
    const auto other = std::ranges::find(numbers_, lint, &LintNumber::lint);
    if (other == numbers_.end()) {
      numbers_.push_back(number);
    } else if (number.IsWorseThan(*other)) {
      *other = number;
    }
  }

  auto ShorterStep() const {
    return [this](double excess) { return timestep_ / excess; };
  }
  auto ShorterStepSquared() const {
    return [this](double excess) { return timestep_ / std::sqrt(excess); };
  }

  void TallStack(const Objects& objects) {
    if (objects.stacked < 2) return;
    const double n = objects.tower;
    Add(Lint::kTallStack, objects,
        n * n * g_ * timestep_ * timestep_ / (objects.least_side * iterations_), kTallStack,
        ShorterStepSquared());
  }

  void LongStep(const Objects& objects) {
    Add(Lint::kLongStep, objects, g_ * timestep_ * timestep_ / objects.least_side,
        walls_ == "none" || box_walls_ ? kLongStepOnBox : kLongStepOnPlane, ShorterStepSquared());
  }

  void ThinWall(const Objects& objects) {
    if (MayBeOn(objects, "ccd")) return;
    Add(Lint::kThinWall, objects,
        FastestComponent(objects) * timestep_ / (objects.least_side + kWallThickness * side_),
        kThinWall, ShorterStep());
  }

  void FastHit(const Objects& objects) {
    // Falling or hitting head-on does not spin a ball.
    const bool is_ball = IsBall(objects);
    if (MayBeOn(objects, "ccd") || (is_ball && count_ == 1 && AlongOneAxis(objects.velocity)))
      return;
    const double speed = is_ball ? objects.velocity.maxCoeff() : FastestComponent(objects);
    const double hit = speed * timestep_ / objects.least_side;
    // What does not cross the room may hit nothing.
    const bool open = speed * Time() < side_;
    Add(Lint::kFastHit, objects, hit, kFastHit, ShorterStep(), open);
  }

  static bool AlongOneAxis(const Vector3d& v) { return (v.array() != 0).count() <= 1; }

  static bool IsBall(const Objects& objects) {
    const auto* type = std::get_if<schema::Word>(&objects.settings->Get("type"));
    return type != nullptr && type->text == "sphere" && objects.least_side == objects.longest_side;
  }

  /// Walls stand across the axes.
  double FastestComponent(const Objects& objects) const {
    const double gained = Fallen(objects);
    double fastest = 0;
    for (int axis = 0; axis < 3; ++axis)
      fastest = std::max(
          fastest, std::hypot(objects.velocity[axis], g_ > 0 ? gained * pull_[axis] / g_ : 0));
    return fastest;
  }

  void EarlySleep(const Objects& objects) {
    if (!world_.On("sleeping") || Time() < kSleepAfter || (rests_ && g_ > 0)) return;
    const double speed = objects.speed + g_ * kSleepAfter;
    if (!(speed > 0 || objects.spin > 0)) return;
    // What hits something before is not in flight.
    if (MayTouch() && objects.speed * kSleepAfter > side_ / 4 / std::cbrt(count_)) return;
    const double slow = std::min(speed > 0 ? kSlowSpeed / speed : kInfinity,
                                 objects.spin > 0 ? kSlowSpin / objects.spin : kInfinity);
    if (slow < 1) return;
    // Another may wake it.
    const bool open = MayTouch() && count_ > 1;
    Add(
        Lint::kEarlySleep, objects, slow, 1, [](double) { return 0.0; }, open);
  }

  void ShortRun(const Objects& objects) {
    double least_side = kInfinity;
    for (const Objects& other : groups_) least_side = std::min(least_side, other.least_side);
    const double n = objects.stacked;
    Add(Lint::kShortRun, objects,
        std::sqrt(n * least_side / g_) * std::max(1.0, n / iterations_) / Time(), kShortRun,
        [this](double excess) { return cycles_ * excess; });
  }

  static bool MayBeOn(const Objects& objects, schema::GroupParameter name) {
    const auto* on = std::get_if<bool>(&objects.settings->Get(name));
    return on == nullptr || *on;
  }

  void SoftContact(const Objects& objects) {
    const double softest = PositiveBounds(objects.settings->Get("contact_stiffness")).least;
    if (!(softest > 0)) return;
    const double sinks = objects.stacked * objects.mass.most * g_ / softest;
    // Half of those come to rest whose damper is the stronger.
    const double damper = PositiveBounds(objects.settings->Get("contact_damping")).least;
    const bool open = damper * damper > 4 * softest * objects.mass.most;
    Add(
        Lint::kSoftContact, objects, sinks, kSoftContact,
        [softest](double excess) { return softest * excess; }, open);
  }

  /// A chain of n equal masses swings with at most 2 sqrt(k/m) times a sine, and what is explicit
  /// explodes where (w dt)^2 + 2 c dt / m passes 4.
  void StiffSpring(const Objects& objects) {
    const double n = objects.quantity;
    const bool anchored = objects.settings->On("links.anchor");
    if (!anchored && n < 2) return;
    const double fastest =
        2 * std::sin(std::numbers::pi / 2 * (anchored ? (2 * n - 1) / (2 * n + 1) : (n - 1) / n));
    const double k = objects.settings->Real("links.stiffness");
    const double c = objects.settings->Real("links.damping");
    Add(Lint::kStiffSpring, objects,
        fastest * std::sqrt((k * timestep_ + 2 * c) * timestep_ / objects.mass.least), kStiffSpring,
        ShorterStep());
  }

  void ThinShape(const Objects& objects) {
    const schema::Value& type = objects.settings->Get("type");
    const bool is_round = MayBe(type, "sphere") && objects.least_side == objects.longest_side;
    if (is_round) return;
    if (count_ < 2 && !box_walls_) return;  // planes are met without GJK
    // What it makes wrong is how deep contacts are, of which only some runs go wrong.
    Add(
        Lint::kThinShape, objects, objects.longest_side / objects.least_side, kThinShape,
        [](double) { return Harmless(kThinShape); }, true);
  }

  void FastSpin(const Objects& objects) {
    Add(Lint::kFastSpin, objects, objects.spin * timestep_, kFastSpin, ShorterStep());
  }

  void SpinDrift(const Objects& objects) {
    const double twist = Twist(objects);
    if (!(twist > 0)) return;
    const double turn = objects.spin * timestep_;
    // Of the energy that the verdict measures against, as far as it is the spin's.
    const double spin = std::pow(objects.spin * objects.longest_side, 2) / 20;
    const double rest = objects.speed * objects.speed / 2 + g_ * side_;
    // A longer run in shorter steps: the number goes with the step, not with its square.
    Add(Lint::kSpinDrift, objects, cycles_ * turn * turn * twist * twist * spin / (spin + rest),
        kSpinDrift, ShorterStep());
  }

  /// How fast a free spin changes its direction in the body, over the spin: |w x Iw| / (|w| |Iw|),
  /// the largest of what may be drawn. 0 about an axis of the body.
  static double Twist(const Objects& objects) {
    if (!(objects.spin > 0)) return 0;
    const schema::Value& type = objects.settings->Get("type");
    // Second moments go with the squares of the sides; a cylinder's by 4/3 more along its axis.
    const auto of = [&](double along_y) {
      Vector3d squares = objects.most_sides.cwiseAbs2();
      if (objects.least_side < objects.most_sides.minCoeff()) squares.x() /= 2;  // each side drawn
      squares.y() *= along_y;
      const Vector3d inertia = Vector3d::Constant(squares.sum()) - squares;
      const auto* turn = std::get_if<Vector3d>(&objects.settings->Get("orientation"));
      const auto* spin = std::get_if<Vector3d>(&objects.settings->Get("angular_velocity"));
      if (turn == nullptr || !turn->isZero(0) || spin == nullptr)
        return 1 - inertia.minCoeff() / inertia.maxCoeff();
      const Vector3d momentum = inertia.cwiseProduct(*spin);
      return spin->cross(momentum).norm() / (spin->norm() * momentum.norm());
    };
    const double most = std::max(of(1), MayBe(type, "cylinder") ? of(4.0 / 3) : 0.0);
    return most > kRounding ? most : 0;
  }

  void HugeBox(const Objects& objects) {
    const double box = objects.most_sides.norm() + FastestSpeed(objects) * timestep_;
    Add(Lint::kHugeBox, objects, box, kHugeBox, [](double) { return Harmless(kHugeBox); });
  }

  /// The distance of neighbouring numbers at `value`.
  double StepAt(double value) const {
    return value > 0 ? std::exp2(std::floor(std::log2(value))) * epsilon_ : 0;
  }

  void CoarsePlace(const Objects& objects) {
    const double place = objects.place.maxCoeff();
    const double coarse = StepAt(place) / objects.least_side;
    // Half a side is where rounding alone moves an object by a quarter of it. Below, much stays
    // put.

    Add(
        Lint::kCoarsePlace, objects, coarse, kCoarsePlace,
        [place](double excess) { return place / excess; }, coarse < kHopelesslyCoarse);
  }

  void LostMotion(const Objects& objects) {
    // What does not get anywhere anyway loses nothing.
    const double noticed = kNoticed * 0.99 * objects.least_side;
    double worst = 0;
    bool open = false;
    Eigen::Vector3d means = objects.velocity + pull_ * Time() / 2, ways = means * Time();
    if (rests_) {
      ways.setConstant(objects.gap);
      means = means.cwiseMin(4 * (pull_ * objects.gap / 2).cwiseSqrt());
    }
    for (int axis = 0; axis < 3; ++axis) {
      const double mean = means[axis], way = ways[axis];
      if (!(way > noticed) || !(mean > 0)) continue;
      const double step = StepAt(objects.place[axis]);
      // Of the whole way: what is lost of a slow part of it does not matter.
      const double lost = step / (means.maxCoeff() * timestep_);
      // What begins within a few steps of what it falls on may not fall.
      if (lost > worst) open = rests_ && way < 3 * step;
      worst = std::max(worst, lost);
      if (pull_[axis] > 0)
        worst = std::max(worst, kGainOverPlace * StepAt(mean) / (pull_[axis] * timestep_));
    }
    const double place = objects.place.maxCoeff();
    Add(
        Lint::kLostMotion, objects, worst, kLostMotion,
        [place](double excess) { return place / excess; }, open);
  }

  void HeavyMass(const Objects& objects) {
    const double limit = single_ ? kHeavySingle : kHeavyDouble;
    Add(Lint::kHeavyMass, objects, objects.mass.most, limit,
        [limit](double) { return Harmless(limit); });
  }

  /// Of groups at known places, one right above the other.
  void NarrowFoot() {
    for (const Objects& load : groups_) {
      const auto above = PlaceOf(load);
      if (!load.moves || !above) continue;
      for (const Objects& foot : groups_) {
        const auto below = PlaceOf(foot);
        if (!below || above->y() <= below->y()) continue;
        const Vector3d aside = (*above - *below).cwiseAbs(), half = foot.most_sides / 2;
        if (aside.x() > half.x() || aside.z() > half.z()) continue;
        const double width = std::min(foot.most_sides.x(), foot.most_sides.z());
        Add(Lint::kNarrowFoot, load, std::min(load.most_sides.x(), load.most_sides.z()) / width,
            kNarrowFoot, [width](double excess) { return width * excess; });
      }
    }
  }

  static std::optional<Vector3d> PlaceOf(const Objects& objects) {
    const schema::Call* layout = schema::AsCall(objects.settings->Get("location"));
    if (layout == nullptr || layout->name != "at") return std::nullopt;
    const auto real = [&](const char* name) {
      return std::get<double>(schema::ArgumentOf(*layout, name));
    };
    return Vector3d(real("x"), real("y"), real("z"));
  }

  /// How far joints open in a step, over what is mended in one.
  void HeavyEnd() {
    for (const Objects& objects : groups_) {
      if (!objects.linked || objects.springs || !objects.settings->On("links.anchor") ||
          objects.quantity < 2)
        continue;
      // The joints open no faster than the end falls.
      const bool open = g_ * Time() * Time() < objects.least_side;
      const double sag = g_ * timestep_ * timestep_ / objects.least_side;
      Add(Lint::kHeavyEnd, objects, objects.load * sag / (iterations_ * world_.Real("solver.erp")),
          kHeavyEndLimit, ShorterStepSquared(), open);
    }
  }

  /// Of objects in one stack, and of groups at known places of which the higher one is the load.
  /// Heaps bear much higher ratios, and which lies on which is chance.
  void MassRatio() {
    for (const Objects& load : groups_) {
      for (const Objects& bearer : groups_) {
        if (!load.moves || !bearer.moves || (&load == &bearer && load.quantity < 2)) continue;
        const auto above = PlaceOf(load), below = PlaceOf(bearer);
        const bool in_one_stack = &load == &bearer && load.stacked > 1;
        if (!in_one_stack && !(above && below && above->y() > below->y())) continue;
        Add(Lint::kMassRatio, load, load.mass.most / bearer.mass.least / iterations_, kMassRatio,
            [this](double excess) { return iterations_ * excess; });
      }
    }
  }

  const plan::WorldSettings& world_;
  const double timestep_, iterations_, cycles_;
  const bool rests_;
  const double side_;
  const Vector3d pull_;
  const double g_;
  const std::string_view walls_;
  const bool box_walls_, single_;
  const double epsilon_;
  std::vector<Objects> groups_;
  double count_ = 0;
  bool has_ground_ = false;
  std::vector<LintNumber> numbers_;
};

}  // namespace

std::vector<LintNumber> LintScene(const plan::Scene& scene) { return SceneNumbers(scene).All(); }

}  // namespace cdb::checks
