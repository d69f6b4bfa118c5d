#include "tests/compiler/random_scenario.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compiler/analysis/expectation.h"
#include "compiler/analysis/soft.h"
#include "compiler/analysis/trace.h"
#include "compiler/schema/catalogue.h"
#include "compiler/schema/parameter_ref.h"
#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/schema.h"
#include "compiler/schema/value.h"

namespace cdb::tests {
namespace {

/// False if the detector needs a package that was missing when cdb was built.
bool IsBuilt(std::string_view detector) {
  const schema::DetectorInfo* info = schema::FindDetector(detector);
  const schema::DetectorPart* part =
      info != nullptr ? schema::FindDetectorPart(info->part) : nullptr;
  return part == nullptr || part->is_built;
}

/// Parameters of `objects` that fixed surfaces do not take.
constexpr std::string_view kOfMovingObjects[] = {
    "quantity",        "links.type",       "links.anchor", "margin", "ccd",
    "linear_velocity", "angular_velocity", "force",        "torque"};

class Maker {
 public:
  explicit Maker(std::mt19937_64& random) : random_(random) {}

  RandomScenario Make() {
    if (Below(6) == 0) AddGround();
    for (const schema::Parameter& parameter : schema::Schema()) {
      // Keeps the number of runs small. AddAccuracy sets the accuracy parameters together.
      if (Below(3) != 0 || !MayBeSet(parameter.name) || parameter.name.starts_with("accuracy.") ||
          !parameter.NamedBlock().empty())
        continue;
      scenario_.settings.push_back(parameter.FullName() + " " + ValueOf(parameter));
    }
    AddAccuracy();
    AddJoints();
    return std::move(scenario_);
  }

 private:
  std::uint64_t Below(std::uint64_t n) { return random_() % n; }

  /// Makes the objects a fixed surface from a file, of its own size or of another.
  void AddGround() {
    is_heights_ = Below(2) == 0;
    scenario_.settings = {
        "objects.type " + CallText(*schema::FindParametrisedWord(
                              is_heights_ ? schema::kHeightsCall : analysis::kSurfaceWord)),
        Below(2) == 0 ? "objects.size native" : "objects.size 20", "objects.mass fixed"};
  }

  /// Joins the objects to the world.
  void AddJoints() {
    const bool is_piled = std::ranges::any_of(scenario_.settings, [](const auto& setting) {
      return setting.starts_with("objects.location") && setting.find("pile") != setting.npos;
    });
    const bool has_closed_form = std::ranges::any_of(scenario_.settings, [](const auto& setting) {
      return setting.starts_with("accuracy.closed_form") || setting.starts_with("omit");
    });
    if (is_piled || has_closed_form || Sets("mass") || Below(3) != 0) return;
    const auto set = [&](std::string_view what, const std::string& value) {
      scenario_.settings.push_back(fmt::format("joints.{} {}", what, value));
    };
    const bool is_reversed = Below(2) == 0, is_driven = Below(2) == 0;
    set("parent", is_reversed ? "objects" : "world");
    set("child", is_reversed ? "world" : "objects");
    set("type", !is_driven ? "ball" : Below(2) == 0 ? "hinge" : "slider");
    if (Below(2) == 0) set("at", Constant(*schema::GroupParameter("joints.at")));
    if (!is_driven) return;
    if (Below(2) == 0) set("axis", Constant(*schema::GroupParameter("joints.axis")));
    if (Below(2) == 0) set("damping", ValueOf(*schema::GroupParameter("joints.damping")));
    if (Below(2) == 0) set("friction", ValueOf(*schema::GroupParameter("joints.friction")));
    if (Below(2) == 0) {
      set("limits.lower", "-0.5");
      set("limits.upper", "0.25 * 2");
    }
    if (Below(2) == 0) {
      set(Below(2) == 0 ? "motor.velocity" : "motor.position", "-3");
      set("motor.effort", "2");
    }
  }

  /// Records errors at multiples of the default time step.
  void AddAccuracy() {
    const bool has_timestep = std::ranges::any_of(
        scenario_.settings, [](const auto& setting) { return setting.starts_with("timestep "); });
    if (has_timestep || Below(2) == 0) return;
    scenario_.settings.push_back("accuracy.metrics " +
                                 Constant(*schema::WorldParameter("accuracy.metrics")));
    scenario_.settings.emplace_back("accuracy.interval 1 / 60");
    for (const schema::WorldParameter parameter : std::initializer_list<schema::WorldParameter>{
             "accuracy.closed_form", "accuracy.reference.contact",
             "accuracy.reference.iterations"}) {
      if (Below(2) == 0)
        scenario_.settings.push_back((*parameter).FullName() + " " + Constant(*parameter));
    }
  }

  std::string Constant(const schema::Parameter& parameter) {
    using enum schema::ParameterType;
    std::vector<std::string> words;
    for (const std::string_view word : parameter.AllWords()) {
      if (parameter.name == "omit" && !CanBeOmitted(word)) continue;
      if (parameter.TakesDetectors() && !IsBuilt(word)) continue;
      if (word == "vertices") continue;  // of soft bodies
      if (word == "counters") continue;  // refused beside several threads
      if (word == "repose") continue;    // refused without a floor
      // Kinematic objects cannot be in schedules or piles.
      if (word == analysis::kKinematicWord) continue;
      words.emplace_back(word);
    }
    if (parameter.type == kWord && parameter.word_source == schema::WordSource::kGroups)
      return "objects";
    if (const auto calls = CallsOf(parameter); !calls.empty() && Below(2) == 0)
      return CallText(*schema::FindParametrisedWord(calls[Below(calls.size())]));
    switch (parameter.type) {
      case kCount:
        return fmt::format("{}", std::max<std::uint64_t>(1, Below(Below(2) == 0 ? 4 : 50)));
      case kReal:
        if (!words.empty() && Below(4) == 0) return words[Below(words.size())];
        return schema::FormatReal(Real(parameter));
      case kSwitch:
        return Below(2) == 0 ? "on" : "off";
      case kWord:
        return words[Below(words.size())];
      case kWords: {
        std::ranges::shuffle(words, random_);
        if (is_in_sweep_ || parameter.StandsAlone(words[0])) return words[0];
        std::erase_if(words, [&](const std::string& word) { return parameter.StandsAlone(word); });
        words.resize(1 + Below(words.size()));
        return fmt::format("{}", fmt::join(words, ", "));
      }
      case kVector:
        if (!parameter.domain.not_zero && Below(4) == 0) return "0";
        return fmt::format("({}, {}, {})", schema::FormatReal(Real(parameter)), Below(9),
                           "-1e-3 * 2");
      case kRatio:
        return fmt::format("1 : {} : {}", 1 + Below(5), schema::FormatReal(0.5 + Fraction()));
      case kText:
        if (parameter.name != "file") return "any";
        return fmt::format("\"{}\"", is_heights_ ? kHeightsFile : kModelFile);
    }
    return {};
  }

  /// Excludes what links cannot have: fixed objects, piles, and a missing anchor. A trace would
  /// leave hardly anything else to set.
  bool MayBeSet(std::string_view parameter) const {
    if (parameter == "trace" || parameter == "coordinates" ||
        parameter == "clock" ||  // is not swept
        parameter.starts_with("configurations.") || parameter.starts_with("soft") ||
        parameter.starts_with("spawn.") || parameter.starts_with("remove."))
      return false;
    const bool is_ground = Sets("mass fixed");
    if (is_ground && Sets(parameter)) return false;
    if (is_ground && std::ranges::count(kOfMovingObjects, parameter) > 0) return false;
    if (parameter == "links.type") return !Sets("mass") && !Sets("location");
    return parameter != "links.anchor" || !Sets("quantity");
  }

  /// The parametrised words that are valid here. `at` and `pair` need a certain number of objects.
  std::vector<std::string_view> CallsOf(const schema::Parameter& parameter) const {
    std::vector<std::string_view> calls = parameter.AllCalls();
    if (is_in_any_ && !parameter.ChoosesCalls()) calls.clear();
    std::erase_if(calls, [&](std::string_view call) {
      return (call == "at" && !Sets("quantity 1")) || (call == "pair" && !Sets("quantity 2")) ||
             call == schema::kPosesCall || call == schema::kPathCall ||  // there is no file for it
             call == schema::kRelativeCall ||                            // there is no other group
             call == schema::kTableCall || call == schema::kHeightsCall ||
             call == schema::kHeightCall || call == schema::kImplicitCall ||
             call == schema::kVoxelsCall ||
             call == analysis::kSurfaceWord ||  // for fixed objects only
             call == analysis::kRopeCall || call == analysis::kClothCall ||
             call == analysis::kBlockCall || call == schema::kSoftCall;  // soft_test.cc has them
    });
    return calls;
  }

  /// Gives some arguments by position, then some by name; the others have defaults.
  std::string CallText(const schema::ParametrisedWord& info) {
    if (info.takes_parts)
      return fmt::format("{}(part(cuboid, (1, 2, 3)), part(sphere, (2, 2, 2), at: (0, {}, 0)))",
                         info.name, Below(3));
    std::string text;
    bool by_place = true;
    for (const schema::Parameter& argument : info.arguments) {
      by_place = by_place && Below(2) == 0;
      if (!argument.DefaultText().empty() && Below(2) == 0) {
        by_place = false;
        continue;
      }
      if (!text.empty()) text += ", ";
      if (!by_place) text += fmt::format("{}: ", argument.name);
      text += Drawn(argument);
    }
    if (text.empty()) return std::string(info.name);
    // A single named argument needs no brackets.
    const bool one_named = text.starts_with(std::string(info.arguments[0].name) + ":") &&
                           text.find(',') == std::string::npos;
    return one_named && Below(2) == 0 ? fmt::format("{} {}", info.name, text)
                                      : fmt::format("{}({})", info.name, text);
  }

  /// True if no scene generated here needs the component, so that a list may name it.
  bool CanBeOmitted(std::string_view component) const {
    const auto sets = [&](std::string_view parameter) { return Sets(parameter); };
    // The defaults need these.
    if (component == "gravity" || component == "static_boxes" || component == "wall_pairs")
      return false;
    if (component == "damping") return !sets("linear_damping") && !sets("angular_damping");
    for (const char* of_links : {"walls", "detection", "solver", "sleeping", "rotation"})
      if (component == of_links && (sets("links.type") || sets("force") || sets("torque")))
        return false;
    if (component == "rotation") return !sets("angular_velocity");
    for (const char* of_ccd : {"walls", "raycast_tree", "detection", "solver", "swept_contacts"})
      if (component == of_ccd) return !sets("ccd");
    return true;
  }

  bool Sets(std::string_view setting) const {
    const std::string full = "objects." + std::string(setting);
    return std::ranges::any_of(scenario_.settings, [&](const std::string& other) {
      return other == full || other.starts_with(full + " ");
    });
  }

  /// A word without its arguments; other text unchanged.
  static std::string_view Head(std::string_view value) {
    const std::size_t end = value.find_first_of("( ");
    return end == 0 ? value : value.substr(0, end);
  }

  double Fraction() { return static_cast<double>(random_() >> 11) * 0x1p-53; }
  double Real(const schema::Parameter& parameter) {
    const double value = std::ldexp(0.5 + Fraction() / 2, -static_cast<int>(Below(4)));
    return value * std::min(20.0, parameter.domain.max);
  }

  std::string ValueOf(const schema::Parameter& parameter) {
    using enum schema::ParameterType;
    const bool sweepable = parameter.name != "repeats" &&
                           parameter.concern != schema::Concern::kReport && scenario_.points <= 16;
    if (sweepable && Below(4) == 0) {
      std::vector<std::string> values;
      is_in_sweep_ = true;
      for (int i = 0; i < 3; ++i) {
        const std::string value = Constant(parameter);
        // `ring` and ring(radius: fit) are the same layout.
        const auto is_same = [&](const std::string& other) { return Head(other) == Head(value); };
        if (std::ranges::none_of(values, is_same)) values.push_back(value);
      }
      is_in_sweep_ = false;
      scenario_.points *= values.size();
      return fmt::format("sweep({}){}", fmt::join(values, ", "),
                         Below(4) == 0 ? " as \"a title\"" : "");
    }
    return Drawn(parameter);
  }

  /// A constant or a distribution.
  std::string Drawn(const schema::Parameter& parameter) {
    using enum schema::ParameterType;
    if (!parameter.distribution || Below(2) == 0) return Constant(parameter);
    if (parameter.type == kWord || parameter.type == kSwitch || Below(4) == 0) {
      is_in_any_ = true;
      const std::string first = Constant(parameter), second = Constant(parameter);
      is_in_any_ = false;
      // Numbers, for example, have no weight.
      const bool weighed = parameter.type == kWord || parameter.type == kSwitch;
      return weighed ? fmt::format("any({} {}, {})", first, 1 + Below(5), second)
                     : fmt::format("any({}, {})", first, second);
    }
    const double a = Real(parameter);
    switch (Below(3)) {
      case 0:
        return fmt::format("uniform({}, {})", schema::FormatReal(a / 2), schema::FormatReal(a));
      case 1:
        return fmt::format("normal({}, {})", schema::FormatReal(a), schema::FormatReal(a / 10));
      default:
        return fmt::format("log_uniform({}, {})", schema::FormatReal(a / 8), schema::FormatReal(a));
    }
  }

  std::mt19937_64& random_;
  RandomScenario scenario_;
  bool is_in_sweep_ = false, is_in_any_ = false, is_heights_ = false;
};

}  // namespace

std::string RandomScenario::Text() const {
  return fmt::format("benchmark b {{\n  {}\n}}\n", fmt::join(settings, "\n  "));
}

RandomScenario MakeRandomScenario(std::mt19937_64& random) { return Maker(random).Make(); }

}  // namespace cdb::tests
