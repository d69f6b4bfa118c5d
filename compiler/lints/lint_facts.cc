#include "compiler/lints/lint_facts.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "compiler/analysis/coverage.h"
#include "compiler/analysis/expectation.h"
#include "compiler/analysis/joints.h"
#include "compiler/analysis/soft.h"
#include "compiler/analysis/standing.h"
#include "compiler/analysis/trace.h"
#include "compiler/lints/lints.h"
#include "compiler/schema/catalogue.h"
#include "compiler/schema/cumulative.h"
#include "compiler/schema/formula.h"
#include "compiler/schema/parametrised_words.h"
#include "dsl/text/check.h"

namespace cdb::lints {
namespace {

using Eigen::Vector3d;

/// A pyramid is as unstable as a stack of this fraction of its height. Measured.
constexpr double kPyramid = 0.4;

/// A constant argument of a layout.
std::optional<double> RealOf(const schema::Call& layout, std::string_view argument) {
  const schema::Number* given = schema::AsNumber(schema::ArgumentOf(layout, argument));
  return given != nullptr ? std::optional<double>(given->AsReal()) : std::nullopt;
}

/// The number of layers of a square pyramid of at least `quantity` objects.
double PyramidHeight(double quantity) {
  double height = 1;
  while (height * (height + 1) * (2 * height + 1) / 6 < quantity) ++height;
  return height;
}

/// Adds facts that follow from the layout.
void AddLayout(double side, GroupFacts& objects) {
  objects.position = Vector3d::Constant(side / 2);
  const schema::Call* layout = schema::AsCall(objects.settings->Get("location"));
  if (layout == nullptr) return;
  const bool is_in_cube = !analysis::IsInBox(*objects.settings);
  if (const auto position = FixedPositionOf(objects)) {
    objects.position = position->cwiseAbs();
  } else if (layout->name == "pair" && is_in_cube) {
    objects.position = Vector3d::Constant(objects.longest_side + *RealOf(*layout, "distance"));
  } else if (layout->name == "grid") {
    const double in_a_row = std::ceil(std::cbrt(objects.quantity));
    if (const auto spacing = RealOf(*layout, "spacing"); spacing && is_in_cube)
      objects.position.setConstant(*spacing * (in_a_row - 1) / 2);
  } else if (layout->name == "line") {
    objects.overlap = std::max(0.0, -RealOf(*layout, "gap").value_or(0));
  } else if (layout->name == "stack") {
    objects.stacked =
        std::min(objects.quantity, RealOf(*layout, "height").value_or(objects.quantity));
    objects.tower = objects.stacked;
    objects.gap = RealOf(*layout, "gap").value_or(0);
  } else if (layout->name == "pyramid") {
    objects.stacked = PyramidHeight(objects.quantity);
    objects.tower = kPyramid * objects.stacked;
    objects.gap = RealOf(*layout, "gap").value_or(0);
  }
}

void AddLinks(GroupFacts& objects) {
  const plan::GroupSettings& settings = *objects.settings;
  objects.chained = objects.linked = settings.WordOr("links.type") != "none";
  objects.springs = settings.WordOr("links.type") == "spring";
  const schema::Number* end_mass = schema::AsNumber(settings.Get("links.end_mass"));
  if (!objects.chained || end_mass == nullptr) return;
  objects.load = end_mass->AsReal() / objects.mass.least;
  objects.mass.least = std::min(objects.mass.least, end_mass->AsReal());
}

/// About the fractions of their bounding boxes that objects of the type fill.
Bounds FillOf(const plan::GroupSettings& settings, const schema::Value& type) {
  constexpr double kOfAMesh = 0.5;
  const schema::Word* word = schema::AsWord(type);
  if (word == nullptr) return {kOfAMesh, kOfAMesh};
  if (word->text == schema::kSuperellipsoidType) {
    // It shrinks as its exponents grow.
    const Bounds e1 = BoundsOf(settings, "e1"), e2 = BoundsOf(settings, "e2");
    return {schema::SuperellipsoidFill(std::min(e1.most, 2.0), std::min(e2.most, 2.0)),
            schema::SuperellipsoidFill(e1.least, e2.least)};
  }
  const auto found =
      std::ranges::find(schema::ObjectTypes(), word->text, &schema::ObjectType::name);
  CDB_CHECK(found != schema::ObjectTypes().end());
  return {found->fill, found->fill};
}

Bounds FillBounds(const plan::GroupSettings& settings) {
  Bounds fills{1, 0};
  for (const schema::Value& type : analysis::TypesOf(settings)) {
    const Bounds fill = FillOf(settings, type);
    fills.least = std::min(fills.least, fill.least);
    fills.most = std::max(fills.most, fill.most);
  }
  return fills;
}

/// The listed places, and the path.
void AddPlaces(const FactReaders& read, GroupFacts& objects) {
  const schema::Call* layout = schema::AsCall(objects.settings->Get("location"));
  if (layout == nullptr) return;
  if (layout->name == schema::kPathCall && read.poses) {
    analysis::PoseFault why;
    objects.path = read.poses(*layout, why);
  } else if (schema::ListsPoints(*layout)) {
    for (const schema::Value& point : layout->arguments)
      objects.places.push_back(*schema::AsVector(point));
  } else if (const auto position = FixedPositionOf(objects)) {
    objects.places = {*position};
  }
}

/// Bounds of the sides; false if they are unknown, as those of a mesh whose file was not read.
bool AddSides(const FactReaders& read, GroupFacts& objects) {
  const plan::GroupSettings& settings = *objects.settings;
  const bool is_native = schema::AsWord(settings.Get("size")) != nullptr;
  const Bounds size = is_native ? Bounds{} : BoundsOf(settings, "size");
  const Vector3d& aspect = std::get<schema::Ratio>(settings.Get("aspect")).parts;
  objects.least_sides.setConstant(std::numeric_limits<double>::infinity());
  objects.most_sides.setZero();
  for (const schema::Value& type : analysis::TypesOf(settings)) {
    analysis::ModelFault why;
    const auto model = read.model ? read.model(type, why) : std::nullopt;
    if (!model && is_native) return false;
    const analysis::ModelFacts facts = model.value_or(analysis::ModelFacts{});
    objects.least_sides = objects.least_sides.cwiseMin(facts.SidesOf(size.least, aspect));
    objects.most_sides = objects.most_sides.cwiseMax(facts.SidesOf(size.most, aspect));
  }
  objects.least_side = objects.least_sides.minCoeff();
  objects.longest_side = objects.most_sides.maxCoeff();
  // One draw for all sides keeps the aspect.
  const schema::Value& sizes = settings.Get("size");
  objects.elongation =
      is_native || schema::AsCall(sizes) != nullptr || schema::AsFormula(sizes) != nullptr
          ? aspect.maxCoeff() / aspect.minCoeff()
          : objects.longest_side / objects.least_side;
  return true;
}

std::optional<GroupFacts> GroupFactsOf(const plan::GroupSettings& settings, std::size_t index,
                                       double side, const FactReaders& read) {
  GroupFacts objects;
  objects.settings = &settings;
  objects.index = index;
  objects.quantity = static_cast<double>(settings.Count("quantity"));
  if (!AddSides(read, objects)) return std::nullopt;
  objects.mass = BoundsOf(settings, "mass");
  objects.moves = objects.mass.most > 0;
  objects.is_kinematic = MayBe(settings.Get("mass"), analysis::kKinematicWord);
  objects.velocity = LargestComponents(settings.Get("linear_velocity"));
  objects.speed = objects.velocity.norm();
  objects.spin = LargestComponents(settings.Get("angular_velocity")).norm();
  objects.is_surface = analysis::HasSurface(settings);
  AddLinks(objects);
  AddLayout(side, objects);
  AddPlaces(read, objects);
  return objects;
}

}  // namespace

Bounds BoundsOf(const plan::GroupSettings& settings, std::string_view name) {
  const schema::Parameter* parameter = schema::FindParameter(name, true);
  CDB_CHECK(parameter != nullptr);
  const schema::Value& value = settings.ValueOf(*parameter);
  Bounds bounds =
      PositiveBounds(value, [&](std::string_view named) { return BoundsOf(settings, named); });
  if (name != "mass" || schema::AsCall(value) == nullptr) return bounds;
  // From a density: the masses of the smallest and of the largest object.
  const Bounds fill = FillBounds(settings), size = BoundsOf(settings, "size");
  const Vector3d& aspect = std::get<schema::Ratio>(settings.Get("aspect")).parts;
  bounds.least *= fill.least * Vector3d(size.least * aspect).prod();
  bounds.most *= fill.most * Vector3d(size.most * aspect).prod();
  return bounds;
}

SceneFacts FactsOf(const plan::Scene& scene, const FactReaders& read) {
  SceneFacts facts;
  const plan::WorldSettings& world = scene.world;
  facts.world = &world;
  facts.timestep = world.Real("timestep");
  facts.iterations = static_cast<double>(world.Count("solver.iterations"));
  facts.cycles = static_cast<double>(world.Count("cycles") + world.Count("warmup"));
  facts.rests = analysis::ExpectationOf(scene) == analysis::Expectation::kRest;
  facts.side = world.Real("world.side");
  facts.acceleration = LargestComponents(world.Get("acceleration"));
  facts.g = facts.acceleration.norm();
  facts.pull = ConstantOf(world.Get("acceleration"));
  facts.has_walls = world.WordOr("world.walls") != "none";
  facts.has_box_walls = facts.has_walls && world.WordOr("world.wall_shape") == "box";
  facts.only_contacts_take_energy = analysis::IsChecked(analysis::Question::kLosses, scene);
  facts.are_gains_judged = analysis::AreGainsJudged(scene);
  facts.is_single = world.WordOr("precision") == "single";
  facts.epsilon = facts.is_single ? std::numeric_limits<float>::epsilon()
                                  : std::numeric_limits<double>::epsilon();
  facts.groups.reserve(scene.groups.size());
  for (std::size_t i = 0; i < scene.groups.size(); ++i) {
    const plan::GroupSettings& settings = scene.groups[i].settings;
    if (settings.Count("quantity") > 0)
      if (auto objects = GroupFactsOf(settings, i, facts.side, read))
        facts.groups.push_back(*std::move(objects));
  }
  for (GroupFacts& objects : facts.groups)
    objects.linked = objects.linked || analysis::IsJoined(scene, scene.groups[objects.index].name);
  for (const GroupFacts& objects : facts.groups) {
    facts.count += objects.quantity;
    if (objects.moves) facts.moving += objects.quantity;
  }
  facts.collisions.emplace(scene);
  facts.has_ground = facts.has_walls || std::ranges::any_of(facts.groups, [](const GroupFacts& o) {
                       return !o.moves;
                     });
  FindTowers(facts);
  FindContacts(facts);
  FindAdjoining(facts);
  FindTrees(scene, facts);
  FindLoads(scene, facts);
  return facts;
}

double SceneFacts::FallHeight(const GroupFacts& objects) const {
  const bool is_straight = pull && pull->x() == 0 && pull->z() == 0 && pull->y() < 0;
  return is_straight ? HeightAboveFloor(objects) : side;
}

double SceneFacts::HeightAboveFloor(const GroupFacts& objects) const {
  if (!objects.places.empty()) {
    double highest = -side / 2;
    for (const Vector3d& place : objects.places) highest = std::max(highest, place.y());
    return std::clamp(highest + side / 2 - objects.least_side / 2, 0.0, side);
  }
  if (objects.tower > 1 && !analysis::IsInBox(*objects.settings))
    return std::min(side, objects.stacked * (objects.most_sides.y() + objects.gap));
  return side;
}

double SceneFacts::FallSpeed(const GroupFacts& objects) const {
  if (rests) return 0;
  // A chain swings at most from above its anchor to below it.
  if (objects.chained && objects.settings->On("links.anchor"))
    return std::min(g * Time(), std::sqrt(8 * g * objects.quantity * objects.longest_side));
  const double fallen = g * Time();
  return has_walls ? std::min(std::sqrt(2 * g * FallHeight(objects)), fallen) : fallen;
}

double SceneFacts::FastestSpeed(const GroupFacts& objects) const {
  const double fallen = FallSpeed(objects);
  return has_walls ? std::hypot(objects.speed, fallen) : objects.speed + fallen;
}

double SceneFacts::FastestComponent(const GroupFacts& objects) const {
  const double gained = FallSpeed(objects);
  double fastest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    double along = g > 0 ? gained * acceleration[axis] / g : 0;
    // On the floor of a tilted scene, objects slide to a wall, but do not fall.
    if (has_walls && !rests && !objects.linked && pull && pull->y() < 0) {
      const double way = axis == 1 ? HeightAboveFloor(objects) : side;
      along = std::min(acceleration[axis] * Time(), std::sqrt(2 * acceleration[axis] * way));
    }
    fastest = std::max(fastest, std::hypot(objects.velocity[axis], along));
  }
  return fastest;
}

std::optional<Vector3d> FixedPositionOf(const GroupFacts& objects) {
  const schema::Call* layout = schema::AsCall(objects.settings->Get("location"));
  if (layout == nullptr || layout->name != "at" || schema::ListsPoints(*layout))
    return std::nullopt;
  return Vector3d(*RealOf(*layout, "x"), *RealOf(*layout, "y"), *RealOf(*layout, "z"));
}

std::optional<Vector3d> ConstantOf(const schema::Value& value) {
  const auto* vector = std::get_if<Vector3d>(&value);
  return vector != nullptr ? std::optional(*vector) : std::nullopt;
}

bool IsBall(const GroupFacts& objects) {
  const auto* type = std::get_if<schema::Word>(&objects.settings->Get("type"));
  return type != nullptr && type->text == "sphere" && objects.least_side == objects.longest_side;
}

bool MayBeOn(const GroupFacts& objects, schema::GroupParameter name) {
  const auto* on = std::get_if<bool>(&objects.settings->Get(name));
  return on == nullptr || *on;
}

namespace {

constexpr double kLeastPart = 1e-3;
/// The maximum number of settings by which a formula is searched.
constexpr std::size_t kMostNamed = 6;

/// The usual minimum and maximum of a distribution of numbers or vectors.
std::pair<Vector3d, Vector3d> EndsOf(const schema::Distribution& distribution) {
  const auto is_vector = [](const schema::Value& value) {
    return schema::AsVector(value) != nullptr;
  };
  if (std::ranges::none_of(distribution.arguments, is_vector)) {
    const schema::Limits range = schema::UsualRange(distribution);
    return {Vector3d::Constant(range.least), Vector3d::Constant(range.most)};
  }
  std::pair<Vector3d, Vector3d> ends;
  for (int i = 0; i < 3; ++i) {
    schema::Distribution component = distribution;
    for (schema::Value& argument : component.arguments) argument = (*schema::AsVector(argument))[i];
    const schema::Limits range = schema::UsualRange(component);
    ends.first[i] = range.least;
    ends.second[i] = range.most;
  }
  return ends;
}

}  // namespace

Bounds PositiveBounds(const schema::Value& value) {
  if (const schema::Number* number = schema::AsNumber(value))
    return {number->AsReal(), number->AsReal()};
  if (const schema::Call* call = schema::AsCall(value); call != nullptr)
    return PositiveBounds(schema::ArgumentOf(*call, "value"));
  const auto* distribution = std::get_if<schema::Distribution>(&value);
  if (distribution == nullptr) return {};
  if (distribution->kind == schema::DistributionKind::kAny) {
    Bounds all{std::numeric_limits<double>::infinity(), 0};
    for (const schema::Value& choice : distribution->arguments) {
      const schema::Number* number = schema::AsNumber(choice);
      if (number == nullptr) continue;
      all.least = std::min(all.least, number->AsReal());
      all.most = std::max(all.most, number->AsReal());
    }
    return all.most > 0 ? all : Bounds{};
  }
  const auto [low, high] = EndsOf(*distribution);
  return {std::max(low.x(), kLeastPart * high.x()), high.x()};
}

Vector3d LargestComponents(const schema::Value& value) {
  if (const auto* vector = std::get_if<Vector3d>(&value)) return vector->cwiseAbs();
  if (const schema::Call* schedule = schema::AsCall(value)) {
    if (schedule->name == "every") return LargestComponents(schema::ArgumentOf(*schedule, "value"));
    // It turns, so that any component can reach the full length.
    return Vector3d::Constant(LargestComponents(schema::ArgumentOf(*schedule, "vector")).norm());
  }
  const auto* distribution = std::get_if<schema::Distribution>(&value);
  if (distribution == nullptr) return Vector3d::Zero();
  if (distribution->kind == schema::DistributionKind::kAny) {
    Vector3d largest = Vector3d::Zero();
    for (const schema::Value& choice : distribution->arguments)
      largest = largest.cwiseMax(LargestComponents(choice));
    return largest;
  }
  const auto [low, high] = EndsOf(*distribution);
  return low.cwiseAbs().cwiseMax(high.cwiseAbs());
}

Bounds PositiveBounds(const schema::Value& value,
                      const std::function<Bounds(std::string_view)>& bounds_of) {
  if (const schema::Call* call = schema::AsCall(value); call != nullptr)
    return PositiveBounds(schema::ArgumentOf(*call, "value"), bounds_of);
  const schema::Formula* formula = schema::AsFormula(value);
  if (formula == nullptr) return PositiveBounds(value);
  std::map<std::string_view, Bounds> named;
  for (const schema::Formula* name : schema::SettingsIn(value))
    if (!named.contains(name->setting)) named[name->setting] = bounds_of(name->setting);
  if (named.size() > kMostNamed) return {};
  Bounds all{std::numeric_limits<double>::infinity(), 0};
  for (unsigned corner = 0; corner < 1u << named.size(); ++corner) {
    const double number = schema::Evaluate(*formula, [&](std::string_view name) {
      const auto at = named.find(name);
      const bool is_most = (corner >> std::distance(named.begin(), at) & 1) != 0;
      return is_most ? at->second.most : at->second.least;
    });
    if (!std::isfinite(number)) return {};
    all.least = std::min(all.least, number);
    all.most = std::max(all.most, number);
  }
  return all.most > 0 ? Bounds{std::max(all.least, kLeastPart * all.most), all.most} : Bounds{};
}

bool IsDrawnOrScheduled(const schema::Value& value) {
  return std::holds_alternative<schema::Distribution>(value) || schema::AsCall(value) != nullptr;
}

// The worst number of each lint in a scene.

namespace {

struct Row {
  Lint lint;
  Formula* formula;
};

/// In the order of Lint.
constexpr Row kFormulae[] = {
    {Lint::kTallStack, TallStack},
    {Lint::kMassRatio, MassRatio},
    {Lint::kHeavyEnd, HeavyEnd},
    {Lint::kNarrowFoot, NarrowFoot},
    {Lint::kOverlap, Overlap},
    {Lint::kLongStep, LongStep},
    {Lint::kThinWall, ThinWall},
    {Lint::kFastHit, FastHit},
    {Lint::kSoftContact, SoftContact},
    {Lint::kStiffSpring, StiffSpring},
    {Lint::kThinShape, ThinShape},
    {Lint::kFastSpin, FastSpin},
    {Lint::kSpinDrift, SpinDrift},
    {Lint::kHugeBox, HugeBox},
    {Lint::kCoarsePlace, CoarsePlace},
    {Lint::kLostMotion, LostMotion},
    {Lint::kLostFall, LostFall},
    {Lint::kHeavyMass, HeavyMass},
    {Lint::kEarlySleep, EarlySleep},
    {Lint::kShortRun, ShortRun},
    {Lint::kInternalEdges, InternalEdges},
    {Lint::kForeseenBounce, ForeseenBounce},
    {Lint::kLossyBounce, LossyBounce},
    {Lint::kLongChain, LongChain},
    {Lint::kSwingingJoint, SwingingJoint},
    {Lint::kCrush, Crush},
    {Lint::kCreep, Creep},
    {Lint::kRollingGain, RollingGain},
    {Lint::kLeaningStack, LeaningStack},
    {Lint::kSlidingBox, SlidingBox},
    {Lint::kTumblingTree, TumblingTree},
};

std::optional<LintNumber> WorstNumber(const Row& row, const SceneFacts& scene) {
  std::optional<LintNumber> worst;
  for (const GroupFacts& objects : scene.groups) {
    if (!objects.moves) continue;
    const auto estimate = row.formula(scene, objects);
    if (!estimate || !(estimate->value > 0)) continue;
    const LintNumber number{row.lint,      estimate->value,  estimate->threshold,
                            objects.index, estimate->remedy, estimate->open};
    if (!worst || number.IsWorseThan(*worst)) worst = number;
  }
  return worst;
}

}  // namespace

double ShorterStep(const SceneFacts& scene, double value, double threshold) {
  return scene.timestep / Excess(value, threshold);
}

double ShorterStepSquared(const SceneFacts& scene, double value, double threshold) {
  return scene.timestep / std::sqrt(Excess(value, threshold));
}

std::vector<LintNumber> LintScene(const plan::Scene& scene, const FactReaders& read) {
  if (analysis::HasSoft(scene)) {  // the other numbers are of rigid bodies
    const auto stiff = StiffSoftSpring(scene, read.model);
    return stiff ? std::vector{*stiff} : std::vector<LintNumber>();
  }
  const SceneFacts facts = FactsOf(scene, read);
  std::vector<LintNumber> numbers;
  for (const Row& row : kFormulae)
    if (const auto worst = WorstNumber(row, facts)) numbers.push_back(*worst);
  return numbers;
}

}  // namespace cdb::lints
