// One name has one value wherever it is printed: the tables of `cdb show` in each format, CSV, the
// JSON document and the pooled rows of the page are read back and compared with each other, and
// with what follows from the generated runs. Nothing here is shared with what is tested.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "runtime/figures/points.h"
#include "runtime/printers/results_document.h"
#include "runtime/printers/show.h"
#include "tests/runtime/printers/generated_results.h"

namespace cdb::tests {
namespace {

using nlohmann::json;
using Strings = std::vector<std::string>;

/// The values of each name, and where they were read.
class Values {
 public:
  /// Texts must be equal.
  void Add(const std::string& name, const std::string& where, const std::string& text) {
    const auto [found, is_new] = texts_.try_emplace(name, where, text);
    if (!is_new) {
      EXPECT_EQ(found->second.second, text)
          << name << " in " << where << ", and in " << found->second.first;
    }
  }
  /// Numbers must agree to three digits; NaN is a missing value.
  void Add(const std::string& name, const std::string& where, double value) {
    const auto [found, is_new] = numbers_.try_emplace(name, where, value);
    const auto& [other_where, other] = found->second;
    const bool is_same = std::isnan(value) || std::isnan(other)
                             ? std::isnan(value) == std::isnan(other)
                             : std::fabs(value - other) <= 0.0051 * std::fabs(other);
    EXPECT_TRUE(is_same) << name << ": " << value << " in " << where << ", " << other << " in "
                         << other_where;
  }
  std::size_t size() const { return texts_.size() + numbers_.size(); }

 private:
  std::map<std::string, std::pair<std::string, std::string>> texts_;
  std::map<std::string, std::pair<std::string, double>> numbers_;
};

const std::string kPhases[] = {"broad", "narrow", "detect", "solve", "integrate", "step"};

double NumberIn(std::string text) {
  std::erase_if(text, [](char c) { return c == '(' || c == ')'; });
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  return text.empty() || *end != '\0' ? NAN : value;
}

double NumberIn(const json& value) { return value.is_null() ? NAN : value.get<double>(); }

/// `1.2 .. 3.4`.
std::pair<double, double> RangeIn(const std::string& text) {
  const std::size_t dots = text.find("..");
  if (dots == text.npos) return {NAN, NAN};
  return {NumberIn(text.substr(0, text.find_last_not_of(' ', dots - 1) + 1)),
          NumberIn(text.substr(text.find_first_not_of(' ', dots + 2)))};
}

Strings Split(const std::string& text, const std::string& by) {
  Strings parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(by, begin), text.size());
    std::string part = text.substr(begin, end - begin);
    part.erase(0, std::min(part.find_first_not_of(' '), part.size()));
    part.erase(part.find_last_not_of(' ') + 1);
    if (!part.empty()) parts.push_back(part);
    begin = end + by.size();
  }
  return parts;
}

struct ReadTable {
  std::string title;
  Strings heads;
  std::vector<Strings> rows;
};

/// The tables of a text for a terminal: a title, heads, a rule, rows. Cells without text are lost.
std::vector<ReadTable> TablesIn(const std::string& text) {
  std::vector<ReadTable> tables;
  Strings lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  for (std::size_t i = 2; i < lines.size(); ++i) {
    if (!lines[i].starts_with("  ---")) continue;
    ReadTable& table = tables.emplace_back(ReadTable{lines[i - 2], Split(lines[i - 1], "  "), {}});
    while (++i < lines.size() && lines[i].starts_with("  ") && !lines[i].ends_with('.'))
      table.rows.push_back(Split(lines[i], "  "));
  }
  return tables;
}

class Reader {
 public:
  explicit Reader(const Generated& generated) : generated_(generated) {}

  std::size_t Check() {
    ReadByHand();
    const TemporaryFolder folder;
    for (const plan::Run& run : generated_.plan().runs)
      if (const MadeUp made = generated_.Of(run); made.status != results::Status::kMissing)
        WriteMadeUp(generated_.plan(), run, made, folder.path());
    const std::filesystem::path path = folder / "out.h5";
    journal::Merge(generated_.plan(), {{"build_type", "Release"}}, folder.path(), path);
    const results::ResultFile file(path);
    ReadCsv(file, "CSV");
    ReadDocument(file, "JSON", false);
    ReadDocument(file, "the page", true);
    ReadStability(file);
    ReadShows(file, "show");
    for (const plan::Axis& axis : generated_.plan().axes)
      for (std::size_t i = 0; i < axis.values.size(); ++i)
        ReadSelection(results::ResultFile(path), axis, i);
    return values_.size();
  }

 private:
  void ReadByHand() {
    for (const auto& [name, point] : generated_.by_hand()) {
      values_.Add("verdict of" + name, "by hand", point.ran.empty() ? "missing" : point.Verdict());
      if (point.ran.empty()) continue;
      values_.Add("mark of" + name, "by hand", point.Fault());
      values_.Add("repeats of" + name, "by hand", static_cast<double>(point.Used().size()));
      values_.Add("first bad cycle of" + name, "by hand",
                  point.FirstBadCycle() ? static_cast<double>(*point.FirstBadCycle()) : NAN);
      for (const std::string& phase : kPhases)
        values_.Add(phase + " of" + name, "by hand", point.Mean());
      values_.Add("peak_rss of" + name, "by hand", point.PeakRss());
    }
  }

  /// The name of a point, from the heads and cells of a table, or the values of a document.
  std::string NameOf(const Strings& heads, const Strings& cells) const {
    std::string name;
    for (const plan::Axis& axis : generated_.plan().axes) {
      const auto found = std::ranges::find(heads, axis.name);
      if (found != heads.end())
        name += " " + axis.name + " " + cells[static_cast<std::size_t>(found - heads.begin())];
    }
    return name;
  }
  std::size_t AxisCount(const Strings& heads) const {
    return static_cast<std::size_t>(std::ranges::count_if(
        generated_.plan().axes,
        [&](const plan::Axis& axis) { return std::ranges::count(heads, axis.name) > 0; }));
  }

  void ReadCsv(const results::ResultFile& file, const std::string& where) {
    std::istringstream lines(printers::CsvText(file, {}).text);
    std::string line;
    std::getline(lines, line);
    const Strings heads = Split(line, ",");
    while (std::getline(lines, line)) {
      Strings cells;
      std::istringstream in(line + ",");
      for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
      ASSERT_EQ(cells.size(), heads.size()) << line;
      const std::string name = NameOf(heads, cells);
      const auto cell = [&](const std::string& head) {
        return cells[static_cast<std::size_t>(std::ranges::find(heads, head) - heads.begin())];
      };
      values_.Add("verdict of" + name, where, cell("verdict"));
      values_.Add("mark of" + name, where, cell("mark"));
      values_.Add("repeats of" + name, where, NumberIn(cell("repeats")));
      for (const std::string& phase : kPhases) {
        values_.Add(phase + " of" + name, where, NumberIn(cell(phase + "_mean_ns")));
        values_.Add("low " + phase + " of" + name, where, NumberIn(cell(phase + "_low_ns")));
        values_.Add("high " + phase + " of" + name, where, NumberIn(cell(phase + "_high_ns")));
      }
      values_.Add("peak_rss of" + name, where, NumberIn(cell("peak_rss_bytes")));
      if (std::ranges::count(heads, "error_position") > 0)
        values_.Add("position of" + name, where, NumberIn(cell("error_position")));
    }
  }

  void ReadDocument(const results::ResultFile& file, const std::string& where, bool for_page) {
    const json document =
        json::parse(printers::ResultsDocument(file, {.file = "x", .for_page = for_page}).text);
    const json& points = document["points"];
    std::size_t stable = 0;
    for (std::size_t i = 0; i < points["at"].size(); ++i) {
      const std::string name = PlaceIn(document, AllAxes(document), points["at"][i]);
      values_.Add("verdict of" + name, where, points["verdict"][i].get<std::string>());
      stable += points["verdict"][i] == "stable";
      values_.Add("mark of" + name, where, points["mark"][i].get<std::string>());
      values_.Add("repeats of" + name, where, NumberIn(points["repeats"][i]));
      values_.Add("first bad cycle of" + name, where, NumberIn(points["first_bad_cycle"][i]));
      ReadTimes(points["times"], i, name, where);
      values_.Add("peak_rss of" + name, where, NumberIn(points["memory"]["peak_rss"][i]));
      if (points.contains("errors"))
        values_.Add("position of" + name, where,
                    NumberIn(points["errors"]["position"]["value"][i]));
    }
    ReadSoundness(document, stable, points["at"].size());
    if (!document["ratios"].is_null())
      for (const char* phase : {"detect", "step"})
        for (const json& mean : document["ratios"]["means"][phase])
          AddRatio(phase, " detector " + mean["detector"].get<std::string>(), where, mean);
    if (for_page)
      for (const json& table : document["pooled"]) ReadPooled(document, table);
  }

  /// The conclusion counts the verdicts of the points.
  void ReadSoundness(const json& document, std::size_t stable, std::size_t all) {
    for (const json& conclusion : document["conclusions"])
      if (conclusion["kind"] == "stability" && all > 1 && stable < all) {
        EXPECT_TRUE(conclusion["answer"].get<std::string>().starts_with(
            std::to_string(stable) + " of " + std::to_string(all) + " configurations are stable"))
            << conclusion;
      }
  }

  void ReadTimes(const json& times, std::size_t i, const std::string& name,
                 const std::string& where) {
    for (const std::string& phase : kPhases) {
      values_.Add(phase + " of" + name, where, NumberIn(times[phase]["mean"][i]));
      values_.Add("low " + phase + " of" + name, where, NumberIn(times[phase]["low"][i]));
      values_.Add("high " + phase + " of" + name, where, NumberIn(times[phase]["high"][i]));
    }
  }

  void AddRatio(const std::string& phase, const std::string& name, const std::string& where,
                const json& ratio) {
    for (const char* part : {"value", "low", "high"})
      values_.Add("ratio " + phase + " " + part + " of" + name, where, NumberIn(ratio[part]));
  }

  void ReadPooled(const json& document, const json& table) {
    const auto axes = table["axes"].get<std::vector<std::size_t>>();
    const json& rows = table["rows"];
    for (std::size_t i = 0; i < rows["at"].size(); ++i) {
      const std::string name =
          PooledName(PlaceIn(document, axes, rows["at"][i]), rows["mark"][i].get<std::string>());
      ReadTimes(rows["times"], i, name, "the page");
      values_.Add("cells of" + name, "the page", NumberIn(rows["points"][i]));
    }
    const json& places = table["places"];
    for (std::size_t i = 0; i < places["at"].size(); ++i) {
      const std::string place = PlaceIn(document, axes, places["at"][i]);
      values_.Add("worst verdict over" + place, "the page",
                  places["verdict"][i].get<std::string>());
      values_.Add("worst verdict over" + place, "by hand", WorstAt(place));
      if (!places.contains("ratios") || axes.size() != 1) continue;
      for (const char* phase : {"detect", "step"}) {
        const json& ratios = places["ratios"][phase];
        if (!ratios["is_matched"][i].get<bool>()) continue;
        json ratio;
        for (const char* part : {"value", "low", "high"}) ratio[part] = ratios[part][i];
        AddRatio(phase, place, "the pooled rows", ratio);
      }
    }
  }

  static std::string PooledName(const std::string& place, const std::string& mark) {
    return " all" + place + " [" + mark + "]";
  }

  std::string WorstAt(const std::string& place) const {
    ByHand all;
    for (const auto& [name, point] : generated_.by_hand()) {
      const Strings wanted = Coordinates(place), has = Coordinates(name);
      const bool is_here = std::ranges::all_of(
          wanted, [&](const std::string& part) { return std::ranges::count(has, part) > 0; });
      if (is_here) all.ran.insert(all.ran.end(), point.ran.begin(), point.ran.end());
    }
    return all.Verdict();
  }
  /// `detector dbvt`, `x 2`.
  static Strings Coordinates(const std::string& place) {
    Strings parts;
    std::istringstream in(place);
    for (std::string axis, value; in >> axis >> value;) parts.push_back(axis + " " + value);
    return parts;
  }

  static std::vector<std::size_t> AllAxes(const json& document) {
    std::vector<std::size_t> axes(document["axes"].size());
    for (std::size_t i = 0; i < axes.size(); ++i) axes[i] = i;
    return axes;
  }
  static std::string PlaceIn(const json& document, const std::vector<std::size_t>& axes,
                             const json& at) {
    std::string place;
    for (std::size_t k = 0; k < axes.size(); ++k) {
      const json& axis = document["axes"][axes[k]];
      place += " " + axis["name"].get<std::string>() + " " +
               axis["value_labels"][at[k].get<std::size_t>()].get<std::string>();
    }
    return place;
  }

  /// Each line is of the graded axis, `x`: `stable 1 .. 2 | missing 4`.
  void ReadStability(const results::ResultFile& file) {
    const ReadTable table = TablesIn("\n" + printers::StabilityMap(file)).at(0);
    const plan::Axis& x = *std::ranges::find(generated_.plan().axes, "x", &plan::Axis::name);
    for (const Strings& row : table.rows)
      for (const std::string& part : Split(row.back(), " | ")) {
        std::istringstream words(part);
        std::string word, dots;
        double from = 0, to = 0;
        words >> word >> from;
        to = words >> dots >> to ? to : from;
        for (const auto& value : x.values) {
          const double at = std::get<double>(value);
          if (at < from || at > to) continue;
          Strings cells = row;
          std::ostringstream number;
          number << at;
          cells.back() = number.str();
          values_.Add("verdict of" + NameOf(table.heads, cells), "the stability map", word);
        }
      }
  }

  void ReadShows(const results::ResultFile& file, const std::string& where) {
    ReadShow(file, {}, where);
    const auto& axes = generated_.plan().axes;
    for (unsigned bits = 1; bits < 1U << axes.size(); ++bits) {
      Strings by;
      for (std::size_t i = 0; i < axes.size(); ++i)
        if ((bits >> i & 1) != 0) by.push_back(axes[i].name);
      ReadShow(file, by, where);
    }
  }

  void ReadShow(const results::ResultFile& file, const Strings& by, const std::string& where) {
    const std::string text = printers::Show(file, {.by = by}).text;
    for (const ReadTable& table : TablesIn(text)) {
      if (table.title.starts_with("Mean of a cycle"))
        ReadPhases(table, by, where);
      else if (table.title.find(" over that of ") != std::string::npos)
        ReadRatios(table, where);
    }
    for (const printers::Format format : {printers::Format::kMarkdown, printers::Format::kLatex})
      ReadFormat(file, by, format, text);
  }

  void ReadPhases(const ReadTable& table, const Strings& by, const std::string& where) {
    const double unit = table.title.ends_with(", us")   ? 1e3
                        : table.title.ends_with(", ms") ? 1e6
                                                        : 1;
    const bool are_ranges = table.title.find(", its ") != std::string::npos;
    for (const Strings& row : table.rows) {
      const std::string mark = row.size() > table.heads.size() ? row.back() : "";
      const std::string place = NameOf(table.heads, row);
      const bool is_pooled = Varied(by) < Varied({});
      const std::string name = is_pooled ? PooledName(VariedPart(place), mark) : Completed(place);
      for (const std::string& phase : kPhases) {
        const std::string& cell = row[static_cast<std::size_t>(
            std::ranges::find(table.heads, phase) - table.heads.begin())];
        if (are_ranges) {
          const auto [low, high] = RangeIn(cell);
          values_.Add("low " + phase + " of" + name, where, low * unit);
          values_.Add("high " + phase + " of" + name, where, high * unit);
        } else {
          values_.Add(phase + " of" + name, where, NumberIn(cell) * unit);
        }
      }
    }
  }

  /// The number of axes with several values, of those named, or of all.
  std::size_t Varied(const Strings& by) const {
    return static_cast<std::size_t>(
        std::ranges::count_if(generated_.plan().axes, [&](const plan::Axis& axis) {
          return axis.values.size() > 1 && (by.empty() || std::ranges::count(by, axis.name) > 0);
        }));
  }
  /// Pooled rows are named by the axes with several values.
  std::string VariedPart(const std::string& place) const {
    std::string part;
    for (const std::string& coordinate : Coordinates(place)) {
      const std::string axis = coordinate.substr(0, coordinate.find(' '));
      const auto found = std::ranges::find(generated_.plan().axes, axis, &plan::Axis::name);
      if (found->values.size() > 1) part += " " + coordinate;
    }
    return part;
  }
  /// With the axes of one value.
  std::string Completed(const std::string& place) const {
    for (const auto& [name, point] : generated_.by_hand()) {
      const Strings has = Coordinates(name);
      if (std::ranges::all_of(Coordinates(place), [&](const std::string& part) {
            return std::ranges::count(has, part) > 0;
          }))
        return name;
    }
    return place;
  }

  /// The geometric means, in the last columns of the row `mean`, with the intervals below it.
  void ReadRatios(const ReadTable& table, const std::string& where) {
    const std::string phase = Split(table.title, " ").at(1);
    const plan::Axis& detectors =
        *std::ranges::find(generated_.plan().axes, "detector", &plan::Axis::name);
    for (const Strings& row : table.rows) {
      if (row[0] != "mean") continue;
      for (std::size_t i = 0; i < detectors.values.size(); ++i)
        values_.Add("ratio " + phase + " value of" + Generated::Coordinate(detectors, i), where,
                    NumberIn(row[row.size() - detectors.values.size() + i]));
    }
  }

  /// The cells of the first table in another format are those for the terminal.
  static void ReadFormat(const results::ResultFile& file, const Strings& by,
                         printers::Format format, const std::string& for_terminal) {
    const bool is_latex = format == printers::Format::kLatex;
    std::istringstream lines(printers::Show(file, {.by = by, .format = format}).text);
    std::vector<Strings> rows;
    bool is_in_table = false;
    for (std::string line; std::getline(lines, line);) {
      const bool is_row = is_latex ? line.ends_with("\\\\") : line.starts_with("| ");
      if (is_in_table && !is_row && !line.starts_with("\\midrule")) break;
      if (!is_row || line.find("---") != line.npos) continue;
      is_in_table = true;
      if (is_latex) line.resize(line.size() - 2);
      std::erase(line, '\\');
      for (std::size_t at = 0; (at = line.find("--")) != line.npos;) line.replace(at, 2, " .. ");
      rows.push_back(Split(line, is_latex ? "&" : "|"));
    }
    const auto tables = TablesIn(for_terminal);
    if (tables.empty()) return;
    ASSERT_EQ(rows.size(), tables[0].rows.size() + 1);
    EXPECT_EQ(rows[0], tables[0].heads);
    for (std::size_t i = 0; i < tables[0].rows.size(); ++i)
      EXPECT_EQ(rows[i + 1], tables[0].rows[i]);
  }

  /// A point has the same figures in a part of the file. Rows over several points have not, if the
  /// part has other cells.
  void ReadSelection(results::ResultFile file, const plan::Axis& axis, std::size_t index) {
    const std::string selection = Split(Generated::Coordinate(axis, index), " ").at(1);
    figures::SelectPart(file, {axis.name + "=" + selection});
    ReadCsv(file, "CSV of " + selection);
    ReadStability(file);
    const json document = json::parse(printers::ResultsDocument(file, {.file = "x"}).text);
    const json& points = document["points"];
    for (std::size_t i = 0; i < points["at"].size(); ++i)
      ReadTimes(points["times"], i, PlaceIn(document, AllAxes(document), points["at"][i]),
                "JSON of " + selection);
  }

  const Generated& generated_;
  Values values_;
};

TEST(Figures, OfOneNameHaveOneValueWhereverTheyArePrinted) {
  std::size_t names = 0;
  for (unsigned seed = 0; seed < 8; ++seed) {
    SCOPED_TRACE(seed);
    const Generated generated(seed);
    names += Reader(generated).Check();
    if (HasFailure()) break;
  }
  EXPECT_GT(names, 2000u);
}

}  // namespace
}  // namespace cdb::tests
