// The formulae behind the table of lints.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "compiler/bounds.h"
#include "compiler/calls.h"
#include "compiler/lints.h"

namespace cdb::compiler {
namespace {

using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Walls that are boxes are so thick, in sides of the cube (runtime/needs/needs.h).
constexpr double kWallThickness = 0.1;

// Thresholds, measured.
constexpr double kTallStack = 0.015, kMassRatio = 10;
constexpr double kLongStepOnPlane = 0.03, kLongStepOnBox = 0.3;
constexpr double kThinWall = 0.5, kSoftContact = 0.04, kThinShape = 30;
constexpr double kFastSpin = 1.41, kSpinDrift = 0.15;
constexpr double kHugeBox = 1e6, kCoarsePlace = 1e-3, kLostMotion = 0.4;
constexpr double kHeavySingle = 1.45e7, kHeavyDouble = 7e15;

/// The objects of one group by the bounds of what they draw. SI units.
struct Objects {
  const Settings* settings = nullptr;
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
};

bool MayBe(const Value& value, std::string_view word) {
  if (const auto* one = std::get_if<Word>(&value)) return one->text == word;
  const auto* drawn = std::get_if<Distribution>(&value);
  return drawn != nullptr && std::ranges::any_of(drawn->arguments, [&](const Value& choice) {
           return MayBe(choice, word);
         });
}

class SceneNumbers {
 public:
  explicit SceneNumbers(const Scene& scene)
      : world_(scene.world),
        timestep_(world_.Real("timestep")),
        iterations_(static_cast<double>(world_.Count("solver.iterations"))),
        cycles_(static_cast<double>(world_.Count("cycles") + world_.Count("warmup"))),
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
      }
      if (box_walls_) ThinWall(objects);
      FastSpin(objects);
      SpinDrift(objects);
      HugeBox(objects);
      LostMotion(objects);
      if (MayTouch()) {
        ThinShape(objects);
        CoarsePlace(objects);
        HeavyMass(objects);
      }
    }
    if (g_ > 0 && has_ground_) MassRatio();
    std::ranges::sort(numbers_, {}, &LintNumber::lint);
    return std::move(numbers_);
  }

 private:
  void AddGroup(const Settings& settings, std::size_t index) {
    Objects objects;
    objects.settings = &settings;
    objects.index = index;
    objects.quantity = static_cast<double>(settings.Count("quantity"));
    const Bounds size = PositiveBounds(settings.Get("size"));
    const Vector3d& aspect = std::get<Ratio>(settings.Get("aspect")).parts;
    objects.least_sides = size.least * aspect;
    objects.most_sides = size.most * aspect;
    objects.least_side = objects.least_sides.minCoeff();
    objects.longest_side = objects.most_sides.maxCoeff();
    objects.mass = PositiveBounds(settings.Get("mass"));
    objects.moves = objects.mass.most > 0;
    objects.velocity = LargestComponents(settings.Get("linear_velocity"));
    objects.speed = objects.velocity.norm();
    objects.spin = LargestComponents(settings.Get("angular_velocity")).norm();
    Locate(objects);
    groups_.push_back(objects);
  }

  void Locate(Objects& objects) const {
    objects.place = Vector3d::Constant(side_ / 2);
    const Call* layout = AsCall(objects.settings->Get("location"));
    if (layout == nullptr) return;
    const auto real = [&](std::string_view argument) {
      const auto* given = std::get_if<double>(&ArgumentOf(*layout, argument));
      return given != nullptr ? std::optional<double>(*given) : std::nullopt;
    };
    if (layout->name == "at") {
      objects.place = Vector3d(*real("x"), *real("y"), *real("z")).cwiseAbs();
    } else if (layout->name == "pair") {
      objects.place = Vector3d::Constant(objects.longest_side + *real("distance"));
    } else if (layout->name == "stack") {
      const auto* height = std::get_if<std::uint64_t>(&ArgumentOf(*layout, "height"));
      objects.stacked = height != nullptr ? std::min(objects.quantity, static_cast<double>(*height))
                                          : objects.quantity;
    } else if (layout->name == "pyramid") {
      while (objects.stacked * (objects.stacked + 1) * (2 * objects.stacked + 1) / 6 <
             objects.quantity)
        ++objects.stacked;
    }
  }

  bool MayTouch() const { return walls_ != "none" || count_ > 1; }

  double Time() const { return timestep_ * cycles_; }

  /// The fastest that an object gets: by falling too, as far as there is to fall.
  double FastestSpeed(const Objects& objects) const {
    const double fallen = g_ * Time();
    if (walls_ == "none") return objects.speed + fallen;
    return std::hypot(objects.speed, std::min(std::sqrt(2 * g_ * side_), fallen));
  }

  /// Half the part of the threshold at which a warning ends: what remedies aim at.
  static double Harmless(double threshold) { return threshold * LintNumber::kDoubtful * 0.999; }

  /// `remedy` is the parameter with which the number would be harmless, a function of how often the
  /// number is too large.
  template <typename Remedy>
  void Add(Lint lint, const Objects& objects, double value, double threshold, Remedy remedy) {
    if (!(value > 0)) return;
    const LintNumber number{lint, value, threshold, objects.index,
                            remedy(value / Harmless(threshold))};
    const auto other = std::ranges::find(numbers_, lint, &LintNumber::lint);
    if (other == numbers_.end()) {
      numbers_.push_back(number);
    } else if (number.Severity() > other->Severity()) {
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
    const double n = objects.stacked;
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
        FastestSpeed(objects) * timestep_ / (objects.least_side + kWallThickness * side_),
        kThinWall, ShorterStep());
  }

  static bool MayBeOn(const Objects& objects, std::string_view name) {
    const auto* on = std::get_if<bool>(&objects.settings->Get(name));
    return on == nullptr || *on;
  }

  void SoftContact(const Objects& objects) {
    const double softest = PositiveBounds(objects.settings->Get("contact_stiffness")).least;
    if (!(softest > 0)) return;
    Add(Lint::kSoftContact, objects, objects.mass.most * g_ / softest, kSoftContact,
        [softest](double excess) { return softest * excess; });
  }

  void ThinShape(const Objects& objects) {
    const Value& type = objects.settings->Get("type");
    const bool is_round = MayBe(type, "sphere") && objects.least_side == objects.longest_side;
    if (is_round || (std::get_if<Word>(&type) != nullptr && MayBe(type, "cuboid"))) return;
    if (count_ < 2 && !box_walls_) return;  // planes are met without GJK
    Add(Lint::kThinShape, objects, objects.longest_side / objects.least_side, kThinShape,
        [](double) { return Harmless(kThinShape); });
  }

  void FastSpin(const Objects& objects) {
    Add(Lint::kFastSpin, objects, objects.spin * timestep_, kFastSpin, ShorterStep());
  }

  void SpinDrift(const Objects& objects) {
    if (MayBe(objects.settings->Get("type"), "sphere") &&
        objects.least_side == objects.longest_side)
      return;
    const double turn = objects.spin * timestep_;
    // A longer run in shorter steps: the number goes with the step, not with its square.
    Add(Lint::kSpinDrift, objects, cycles_ * turn * turn, kSpinDrift, ShorterStep());
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
    Add(Lint::kCoarsePlace, objects, StepAt(place) / objects.least_side, kCoarsePlace,
        [place](double excess) { return place / excess; });
  }

  void LostMotion(const Objects& objects) {
    double worst = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double speed = objects.velocity[axis];
      if (!(speed > 0)) continue;
      worst = std::max(worst, StepAt(objects.place[axis]) / (speed * timestep_));
      if (pull_[axis] > 0) worst = std::max(worst, StepAt(speed) / (pull_[axis] * timestep_));
    }
    const double place = objects.place.maxCoeff();
    Add(Lint::kLostMotion, objects, worst, kLostMotion,
        [place](double excess) { return place / excess; });
  }

  void HeavyMass(const Objects& objects) {
    const double limit = single_ ? kHeavySingle : kHeavyDouble;
    Add(Lint::kHeavyMass, objects, objects.mass.most, limit,
        [limit](double) { return Harmless(limit); });
  }

  /// Where two groups stand at known places, the higher one is the load; else any may be.
  void MassRatio() {
    const auto height = [](const Objects& objects) -> std::optional<double> {
      const Call* layout = AsCall(objects.settings->Get("location"));
      if (layout == nullptr || layout->name != "at") return std::nullopt;
      return std::get<double>(ArgumentOf(*layout, "y"));
    };
    for (const Objects& load : groups_) {
      for (const Objects& bearer : groups_) {
        if (!load.moves || !bearer.moves || (&load == &bearer && load.quantity < 2)) continue;
        const auto above = height(load), below = height(bearer);
        if (above && below && *above <= *below) continue;
        Add(Lint::kMassRatio, load, load.mass.most / bearer.mass.least / iterations_, kMassRatio,
            [this](double excess) { return iterations_ * excess; });
      }
    }
  }

  const Settings& world_;
  const double timestep_, iterations_, cycles_, side_;
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

std::vector<LintNumber> LintScene(const Scene& scene) { return SceneNumbers(scene).All(); }

}  // namespace cdb::compiler
