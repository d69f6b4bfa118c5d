#include "runtime/document/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "compiler/schema/metrics.h"
#include "runtime/document/source.h"
#include "runtime/statistics/cells.h"
#include "runtime/statistics/numbers.h"

namespace cdb::document {
namespace {

using GridPoint = DocumentSource::GridPoint;

std::string CsvNumber(double value) {
  return std::isfinite(value) ? fmt::format("{:.6g}", value) : std::string();
}

class CsvTable {
 public:
  CsvTable(const DocumentSource& source, const CsvOptions& options)
      : source_(source), file_(source.file()) {
    AddAxes();
    Add("verdict",
        [this](const GridPoint& point) { return statistics::WorstVerdict(file_, point.at).word; });
    Add("mark", [this](const GridPoint& point) {
      return point.measured != nullptr ? point.measured->Mark()
                                       : statistics::WorstVerdict(file_, point.at).word;
    });
    Add("repeats", [](const GridPoint& point) {
      return std::to_string(point.measured == nullptr ? 0 : point.measured->cells.size());
    });
    if (source.HasTimes())
      for (std::size_t i = 0; i < measure::kPhaseCount; ++i)
        if (const auto phase = static_cast<measure::Phase>(i);
            options.phases.empty() ||
            std::ranges::find(options.phases, phase) != options.phases.end())
          AddPhase(phase);
    AddCounts();
    AddErrors();
  }

  std::string Text() const {
    std::string text = Line([](const Column& column) { return column.head; });
    for (const GridPoint& point : source_.points())
      text += Line([&](const Column& column) { return column.value(point); });
    return text;
  }

 private:
  struct Column {
    std::string head;
    std::function<std::string(const GridPoint&)> value;
  };

  void Add(std::string head, std::function<std::string(const GridPoint&)> value) {
    columns_.push_back({std::move(head), std::move(value)});
  }
  /// A numeric column for points with cycles.
  void AddNumber(std::string head, std::function<double(const statistics::MeasuredPoint&)> value) {
    Add(std::move(head), [value = std::move(value)](const GridPoint& point) {
      return point.measured == nullptr ? std::string() : CsvNumber(value(*point.measured));
    });
  }

  void AddAxes() {
    for (std::size_t i = 0; i < file_.axes().size(); ++i)
      Add(file_.axes()[i].name, [this, i](const GridPoint& point) {
        const plan::Coordinate& value = file_.axes()[i].values[point.at[i]];
        if (const auto* number = std::get_if<double>(&value)) return fmt::format("{}", *number);
        return std::get<std::string>(value);
      });
  }

  void AddPhase(measure::Phase phase) {
    statistics::CycleTimes& times = source_.times();
    const std::string name(measure::PhaseNames()[measure::IndexOf(phase)]);
    const auto figure =
        [&times, phase](const statistics::MeasuredPoint& point) -> const statistics::Estimate& {
      return times.FigureOf(point, phase);
    };
    AddNumber(fmt::format("{}_{}_ns", name, times.StatisticName()),
              [figure](const statistics::MeasuredPoint& point) { return figure(point).value; });
    AddNumber(name + "_low_ns", [figure, &times](const statistics::MeasuredPoint& point) {
      return times.IntervalOf(figure(point)).low;
    });
    AddNumber(name + "_high_ns", [figure, &times](const statistics::MeasuredPoint& point) {
      return times.IntervalOf(figure(point)).high;
    });
  }

  void AddCounts() {
    for (const char* series : {"pairs", "manifolds", "contacts", "missed_pairs"})
      if (file_.Has(series))
        AddNumber(series, [this, series](const statistics::MeasuredPoint& point) {
          return statistics::Mean(file_.ReadSeries(series, point.cells[0]));
        });
    if (file_.Has("peak_rss"))
      AddNumber("peak_rss_bytes", [this](const statistics::MeasuredPoint& point) {
        double most = statistics::kNone;
        for (const auto& cell : point.cells)
          most = std::fmax(most, file_.ReadReal("peak_rss", cell));
        return most;
      });
  }

  void AddErrors() {
    for (const schema::ErrorInfo& error : schema::Errors())
      for (const char* suffix : {"", "_floor"}) {
        const std::string name = std::string(error.name) + suffix;
        if (!file_.Has("accuracy/" + name)) continue;
        // With a prefix, as an axis may have the same name.
        AddNumber("error_" + name, [this, name](const statistics::MeasuredPoint& point) {
          return file_.ReadReal("accuracy/" + name, point.cells[0]);
        });
      }
  }

  template <typename Of>
  std::string Line(Of of) const {
    std::string line;
    for (const Column& column : columns_) {
      if (&column != &columns_.front()) line += ',';
      line += CsvField(of(column));
    }
    return line + '\n';
  }

  const DocumentSource& source_;
  const store::ResultFile& file_;
  std::vector<Column> columns_;
};

}  // namespace

std::string CsvField(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string field = "\"";
  for (const char c : text) {
    if (c == '"') field += '"';
    field += c;
  }
  return field + '"';
}

report::ShowText CsvText(const store::ResultFile& file, const CsvOptions& options) {
  const DocumentSource source(file, options.only_sound, options.statistic);
  return {CsvTable(source, options).Text(), source.groups().bad.size()};
}

}  // namespace cdb::document
