#include "runtime/cli/help/first_scene.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <ranges>
#include <vector>

#include "dsl/format.h"
#include "dsl/text/check.h"
#include "dsl/text/source.h"

namespace cdb::help {
namespace {

struct Falling : SceneWord {
  std::string_view type;  ///< as in `.cdb`
};
constexpr Falling kObjects[] = {
    {{"boxes", "cubes"}, "cuboid"},
    {{"spheres", "balls"}, "sphere"},
    {{"mixed", "spheres, cubes, cylinders and cones"}, "any(sphere, cuboid, cylinder, cone)"},
    {{"mesh", "rings of convex hulls"}, "torus"},
};

struct Template : SceneWord {
  std::uint64_t quantity;  ///< the default number of objects
  std::string_view title, head, body;
};
/// `{}`: the quantity, in `scaling` its quarter and its half before it.
constexpr Template kTemplates[] = {
    {{"detectors", "which broad phase takes the least time"},
     200,
     "Which detector is the fastest?",
     "Look at the first lines of the results: which detector is the fastest, and by how much.",
     "cycles 240  # 1 s\n"
     "timestep 1 / 240\n"
     "repeats 3  # of every run, so that the spread of the times is known\n"
     "detector sweep(dbvt, sap, sap32, simple)  # a run for each\n"},
    {{"error", "how the error falls with the time step"},
     20,
     "How small must the time step be?",
     "Look at `cdb show FILE --error energy`: the error against the run time. Each run is "
     "compared\n"
     "# with one of small steps, which is executed once.",
     "let hz = sweep(120, 240, 480)  # a run for each\n"
     "timestep 1 / hz\n"
     "cycles hz  # 1 s\n"
     "solver.iterations sweep(5, 20)\n"
     "accuracy {\n"
     "metrics position, energy, penetration\n"
     "interval 1 / 15\n"
     "reference { timestep 1 / 1920 ; precision double ; detector dbvt ; iterations 100 ; "
     "contact same }\n"
     "}\n"},
    {{"scaling", "how the time grows with the number of objects"},
     400,
     "How does the time grow with the number of objects?",
     "Look at `cdb show FILE --plot`: the time over the number of objects.",
     "cycles 240  # 1 s\n"
     "timestep 1 / 240\n"
     "repeats 3  # of every run, so that the spread of the times is known\n"
     "detector sweep(dbvt, sap)  # a run for each\n"},
};

template <typename Row>
const Row& RowOf(std::span<const Row> rows, std::string_view word) {
  const auto found = std::ranges::find(rows, word, [](const Row& row) { return row.word; });
  CDB_CHECK(found != rows.end());
  return *found;
}

template <typename Row>
std::span<const SceneWord> WordsOf(std::span<const Row> rows) {
  static const std::vector<SceneWord> kWords(rows.begin(), rows.end());
  return kWords;
}

/// With this, and the time steps above, all runs are sound.
constexpr double kSize = 1;  // m

/// The side of a box of which the objects fill a sixteenth, m.
double SideFor(std::uint64_t quantity) {
  return std::ceil(kSize * std::cbrt(16.0 * static_cast<double>(quantity)));
}

std::uint64_t DefaultQuantity(const SceneChoice& choice) {
  const std::uint64_t quantity =
      RowOf(std::span<const Template>(kTemplates), choice.compared).quantity;
  return choice.objects == "mesh" ? quantity / 4 : quantity;
}

using Read = std::function<std::optional<std::string>(const std::string&)>;

std::optional<std::string> AskForWord(std::string_view question, std::span<const SceneWord> words,
                                      const Read& read) {
  std::string text = fmt::format("{}\n", question);
  for (const SceneWord& word : words) text += fmt::format("  {:10} {}\n", word.word, word.doc);
  text += fmt::format("[{}]: ", words[0].word);
  for (;;) {
    std::optional<std::string> answer = read(text);
    if (answer && answer->empty()) return std::string(words[0].word);
    if (!answer || std::ranges::find(words, *answer, &SceneWord::word) != words.end())
      return answer;
    text = fmt::format("'{}' is none of {} [{}]: ", *answer,
                       fmt::join(words | std::views::transform(&SceneWord::word), ", "),
                       words[0].word);
  }
}

std::optional<std::uint64_t> AskForNumber(const std::string& question, std::uint64_t otherwise,
                                          const Read& read) {
  std::string text = fmt::format("{} [{}]: ", question, otherwise);
  for (;;) {
    const std::optional<std::string> answer = read(text);
    if (!answer) return std::nullopt;
    if (answer->empty()) return otherwise;
    std::uint64_t number = 0;
    const char* const end = answer->data() + answer->size();
    const auto [stop, error] = std::from_chars(answer->data(), end, number);
    if (error == std::errc{} && stop == end && number >= 1 && number <= kMostSceneObjects)
      return number;
    text = fmt::format("a whole number from 1 to {} [{}]: ", kMostSceneObjects, otherwise);
  }
}

}  // namespace

std::span<const SceneWord> SceneTemplates() {
  return WordsOf(std::span<const Template>(kTemplates));
}
std::span<const SceneWord> SceneObjects() { return WordsOf(std::span<const Falling>(kObjects)); }

std::string SceneText(const SceneChoice& choice, const std::string& name, const std::string& file) {
  const Template& made = RowOf(std::span<const Template>(kTemplates), choice.compared);
  const Falling& falling = RowOf(std::span<const Falling>(kObjects), choice.objects);
  const std::uint64_t n = choice.quantity > 0 ? choice.quantity : DefaultQuantity(choice);
  const bool is_swept = choice.compared == "scaling" && n >= 4;
  const std::string quantity =
      is_swept ? fmt::format("sweep({}, {}, {})  # a run for each", n / 4, n / 2, n)
               : fmt::format("{}", n);
  std::string head(made.head);
  if (const std::size_t place = head.find("FILE"); place != head.npos) head.replace(place, 4, file);
  const std::string text = fmt::format(
      "# {} {} fall into a box.\n"
      "# {}\n"
      "# Change a value and run again: finished runs that are still part of the scenario are "
      "kept.\n"
      "# `cdb doc WORD` explains each word of this file.\n"
      "benchmark {} \"{}\" {{\n"
      "{}"
      "world.side {}  # m\n"
      "objects {{\n"
      "quantity {}\n"
      "type {}\n"
      "size {}  # m\n"
      "orientation random\n"
      "}}\n"
      "}}\n",
      n, falling.doc, head, name, made.title, made.body, SideFor(n), quantity, falling.type, kSize);
  return dsl::Format(text::Source(name, text));
}

std::optional<SceneChoice> AskForScene(const Read& read) {
  SceneChoice choice;
  const auto objects = AskForWord("What falls?", SceneObjects(), read);
  if (!objects) return std::nullopt;
  const auto compared = AskForWord("What is compared?", SceneTemplates(), read);
  if (!compared) return std::nullopt;
  choice.objects = *objects;
  choice.compared = *compared;
  const auto quantity = AskForNumber("How many fall?", DefaultQuantity(choice), read);
  if (!quantity) return std::nullopt;
  choice.quantity = *quantity;
  return choice;
}

}  // namespace cdb::help
