// The sentences on the method of a measurement, for the section of a paper (`cdb show --method`).

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "compiler/schema/components.h"
#include "runtime/figures/model.h"
#include "runtime/figures/times.h"
#include "runtime/printers/document.h"
#include "runtime/printers/show.h"
#include "runtime/terminal/console.h"
#include "runtime/terminal/table.h"

namespace cdb::printers {
namespace {

std::string Counted(std::size_t count, std::string_view noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

/// `once`, `twice`, `7 times`.
std::string TimesText(std::uint64_t count) {
  return count == 1 ? "once" : count == 2 ? "twice" : fmt::format("{} times", count);
}

/// The number at the beginning of `12345 kB`; NaN if there is none.
double KilosIn(const std::string& text) {
  double value = figures::kNone;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

class Method {
 public:
  explicit Method(const figures::Model& model) : model_(model), file_(model.file()) {}

  std::vector<std::string> Sentences() const {
    std::vector<std::string> all;
    for (std::string sentence : {Machine(), Software(), Procedure(), Statistic()})
      if (!sentence.empty()) all.push_back(std::move(sentence));
    return all;
  }

 private:
  std::string Fact(const char* name) const { return file_.ReadProvenance(name); }

  std::size_t RunCount() const {
    const figures::CellGroups& groups = model_.runs();
    return groups.good.size() + groups.bad.size();
  }

  /// `All 112 runs were executed on one machine (AMD EPYC, 2 logical processors) under …`
  std::string Machine() const {
    std::set<std::string> hosts;
    for (const figures::GridPoint& point : model_.grid())
      for (const figures::Cell& cell : figures::CellsThatRan(file_, point.at))
        hosts.insert(file_.ReadProvenance("host", cell));
    // Those of several machines would not belong to one another.
    std::vector<std::string> facts;
    if (hosts.size() <= 1) facts = Processors();
    if (std::string cpu = Fact("cpu"); !cpu.empty()) facts.insert(facts.begin(), std::move(cpu));
    if (const double kilos = KilosIn(Fact("memory")); hosts.size() <= 1 && std::isfinite(kilos))
      facts.push_back(fmt::format("{:.1f} GB of memory", kilos * 1024 / 1e9));
    const std::string system = Fact("system"), kernel = Fact("kernel");
    return fmt::format(
        "{} executed on {}{}{}{}.",
        RunCount() == 1 ? "The run was" : fmt::format("All {} runs were", RunCount()),
        hosts.size() <= 1 ? "one machine" : Counted(hosts.size(), "machine"),
        facts.empty() ? "" : fmt::format(" ({})", fmt::join(facts, ", ")),
        system.empty() ? "" : " under " + Joint(system),
        kernel.empty() ? "" : " with kernel " + Joint(kernel));
  }

  /// `16 logical processors`, `base clock 2.10 GHz`, `frequency governor performance`.
  std::vector<std::string> Processors() const {
    std::vector<std::string> facts;
    if (const std::string count = Fact("cpus"); !count.empty())
      facts.push_back(fmt::format("{} logical processor{}", count, count == "1" ? "" : "s"));
    const auto add_clock = [&](const char* name, const char* words) {
      if (const double kilos = KilosIn(Fact(name)); std::isfinite(kilos))
        facts.push_back(fmt::format("{} {:.2f} GHz", words, kilos / 1e6));
    };
    add_clock("cpu_base_clock", "base clock");
    add_clock("cpu_max_clock", "maximum clock");
    if (const std::string governor = Fact("cpu_governor"); !governor.empty())
      facts.push_back("frequency governor " + governor);
    return facts;
  }

  /// Bullet, cdb and the compiler; then what was omitted.
  std::string Software() const {
    std::vector<std::string> build;
    std::string commit = Fact("commit"), compiler = Fact("compiler"),
                flags = Fact("compiler_flags");
    if (!commit.empty()) build.push_back("commit " + commit);
    if (compiler.starts_with("GNU ")) compiler.replace(0, 3, "GCC");
    flags.erase(0, flags.find_first_not_of(' '));
    if (!compiler.empty())
      build.push_back("compiled by " + compiler + (flags.empty() ? "" : " with " + flags));
    if (const std::string type = Fact("build_type"); !type.empty() && type != "Release")
      build.push_back("build type " + type);
    const std::string precision = Fact("precision");
    const auto versioned = [this](const char* name, const char* fact) {
      const std::string version = Fact(fact);
      return version.empty() ? std::string(name) : fmt::format("{} {}", name, version);
    };
    return fmt::format("{} used {}{}, run by {}{}.{}", RunCount() == 1 ? "It" : "They",
                       versioned("Bullet", "bullet_version"),
                       precision.empty() ? "" : fmt::format(" in {} precision", Joint(precision)),
                       versioned("cdb", "cdb_version"),
                       build.empty() ? "" : fmt::format(" ({})", fmt::join(build, ", ")),
                       Omissions());
  }

  /// `single; double` as words.
  static std::string Joint(std::string list) {
    for (std::size_t at = 0; (at = list.find("; ", at)) != list.npos;) list.replace(at, 2, " and ");
    return list;
  }

  std::string Omissions() const {
    if (!file_.Has("omitted")) return {};
    const std::size_t all = model_.points().size();
    std::vector<std::string> parts;
    for (const schema::ComponentInfo& info : schema::Components()) {
      if (!info.IsVisible()) continue;
      const auto count = static_cast<std::size_t>(
          std::ranges::count_if(model_.points(), [&](const figures::MeasuredPoint& point) {
            return std::ranges::find(point.left_out, info.name) != point.left_out.end();
          }));
      if (count == 0) continue;
      // Without its conditions.
      const std::string doc(
          info.doc.substr(0, std::min(info.doc.find(';'), info.doc.find(", if"))));
      parts.push_back(
          fmt::format("{}{}", doc,
                      count < all ? fmt::format(" (in {} of {} configurations)", count, all) : ""));
    }
    if (parts.empty()) return " No part of the engine that affects the times was omitted.";
    return fmt::format(" Omitted, because the scene does not need {}: {}.",
                       parts.size() == 1 ? "it" : "them", fmt::join(parts, "; "));
  }

  /// `100 steps (1.67 s of simulated time)`.
  std::string Length() const {
    std::set<std::uint64_t> steps;
    for (const figures::MeasuredPoint& point : model_.points())
      for (const figures::Cell& cell : point.cells) steps.insert(file_.ReadCycleCount(cell));
    if (steps.empty()) return {};
    const std::string time = SimulatedTime(model_);
    return fmt::format(" for {}{} step{}{}", *steps.begin(),
                       steps.size() > 1 ? fmt::format(" to {}", *steps.rbegin()) : "",
                       *steps.rbegin() == 1 ? "" : "s",
                       time.empty() ? time : fmt::format(" ({} of simulated time)", time));
  }

  std::string Procedure() const {
    const std::size_t points = model_.grid().size();
    if (points == 0) return {};
    const std::uint64_t repeats = file_.begun_repeats();
    const std::string jobs = Fact("jobs");
    const bool is_parallel = !jobs.empty() && jobs != "1";
    std::string text = fmt::format(
        "{} was run {}{}, {} a separate process, {}",
        points == 1 ? "The configuration" : fmt::format("Each of the {} configurations", points),
        TimesText(repeats), Length(), repeats == 1 ? "in" : "each time in",
        is_parallel ? fmt::format("up to {} runs in parallel", Joint(jobs)) : "one run at a time");
    if (repeats > 1 && points > 1)
      text += fmt::format("; all were run once before any was repeated{}",
                          model_.ComparedDetectors() ? ", with the detectors in random order" : "");
    return text + ".";
  }

  std::string Statistic() const {
    if (!model_.HasTimes()) return {};
    switch (model_.times().bootstrap().kind()) {
      case figures::IntervalKind::kAbsent:
        return "Times are means over the steps of one run, without intervals.";
      case figures::IntervalKind::kRange:
        return fmt::format(
            "The time of each step is its median over the repeats, and the time of a "
            "configuration is the mean over its steps; ranges are over all bootstrap samples of "
            "the {} repeats, which are too few for a confidence interval.",
            file_.begun_repeats());
      case figures::IntervalKind::kInterval:
        break;
    }
    return "The time of each step is its median over the repeats, and the time of a configuration "
           "is the mean over its steps; intervals are 95 % confidence intervals by the bootstrap "
           "over whole runs (expanded percentiles after Hesterberg 2015, outliers winsorised).";
  }

  const figures::Model& model_;
  const results::ResultFile& file_;
};

}  // namespace

std::string SimulatedTime(const figures::Model& model) {
  double least = figures::kNone, most = figures::kNone;
  for (const figures::MeasuredPoint& point : model.points()) {
    // A cycle of a trace has no step.
    if (!point.IsSound() || (model.HasTimes() && std::isnan(model.MsPerSecondOf(point).value)))
      continue;
    const double cycles = static_cast<double>(model.file().ReadCycleCount(point.cells[0]));
    least = std::fmin(least, cycles * model.TimeStepOf(point));
    most = std::fmax(most, cycles * model.TimeStepOf(point));
  }
  if (std::isnan(least)) return {};
  const std::string first = terminal::ShortNumber(least), last = terminal::ShortNumber(most);
  return first == last ? first + " s" : fmt::format("{} to {} s", first, last);
}

std::vector<std::string> MethodSentences(const figures::Model& model) {
  return Method(model).Sentences();
}

Printed ShowMethod(const results::ResultFile& file, Format format) {
  const figures::Model model(file);
  const std::string text = fmt::format("{}", fmt::join(MethodSentences(model), " "));
  return {terminal::Wrapped(EscapedText(text, format), 0, kLineWidth), model.bad_count(),
          figures::CountNotMet(model.requirements())};
}

}  // namespace cdb::printers
