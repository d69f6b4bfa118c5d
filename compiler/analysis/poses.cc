#include "compiler/analysis/poses.h"

#include <algorithm>

#include "compiler/schema/parametrised_words.h"

namespace cdb::analysis {

namespace {

const schema::Call* LayoutCalled(std::string_view name, const plan::Group& group) {
  const schema::Call* layout = schema::AsCall(group.settings.Get("location"));
  return layout != nullptr && layout->name == name ? layout : nullptr;
}

}  // namespace

const schema::Call* PosesOf(const plan::Group& group) {
  return LayoutCalled(schema::kPosesCall, group);
}

const schema::Call* PathOf(const plan::Group& group) {
  return LayoutCalled(schema::kPathCall, group);
}

bool IsCsv(const schema::Call& poses) {
  std::string end = std::get<schema::Text>(schema::ArgumentOf(poses, "file")).text;
  end.erase(0, end.size() - std::min<std::size_t>(end.size(), 4));
  for (char& c : end)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return end == ".csv";
}

}  // namespace cdb::analysis
