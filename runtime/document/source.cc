#include "runtime/document/source.h"

#include <utility>
#include <variant>

#include "runtime/statistics/cells.h"

namespace cdb::document {

DocumentSource::DocumentSource(const store::ResultFile& file, bool only_sound,
                               statistics::CycleStatistic statistic)
    : file_(file),
      measured_(statistics::MeasuredPoints(file, only_sound)),
      times_(file, statistic),
      groups_(statistics::GroupCells(file)),
      findings_(statistics::FindingsOf(file)),
      references_(file.ReadReferenceTroubles()) {
  std::map<statistics::Point, const statistics::MeasuredPoint*> measured;
  for (const statistics::MeasuredPoint& point : measured_) measured[point.at] = &point;
  for (const store::ResultFile::Cell& cell : statistics::AllCells(file)) {
    const store::Status status = file.ReadStatus(cell);
    if (status == store::Status::kSkipped || status == store::Status::kMissing) continue;
    if (!points_.empty() && points_.back().at == cell.at) continue;
    const auto found = measured.find(cell.at);
    if (found == measured.end() && only_sound) continue;
    index_[cell.at] = points_.size();
    points_.push_back({cell.at, found == measured.end() ? nullptr : found->second});
  }
}

Json DocumentSource::Value(std::size_t axis, std::size_t index) const {
  const plan::Coordinate& value = file_.axes()[axis].values[index];
  if (const auto* number = std::get_if<double>(&value)) return JsonNumber(*number, 17);
  return std::get<std::string>(value);
}

Json DocumentSource::Place(const std::vector<std::size_t>& axes,
                           const statistics::Point& at) const {
  Json place = Json::object();
  for (std::size_t i = 0; i < axes.size(); ++i)
    place[file_.axes()[axes[i]].name] = Value(axes[i], at[i]);
  return place;
}

std::string Sentence(std::string_view line) {
  const auto begin = line.find_first_not_of(" \n"), end = line.find_last_not_of(" \n");
  return begin == std::string_view::npos ? "" : std::string(line.substr(begin, end + 1 - begin));
}

}  // namespace cdb::document
