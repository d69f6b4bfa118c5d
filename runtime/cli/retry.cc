#include "runtime/cli/retry.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <sstream>
#include <string_view>

#include "dsl/diagnostics.h"
#include "runtime/cli/exit_status.h"
#include "runtime/measure/noise.h"

namespace cdb::cli {
namespace {

constexpr std::string_view kNoisy = "noisy";
constexpr std::string_view kWords[] = {"failed", "crashed", "timed_out", kNoisy};

}  // namespace

RetryChoice::RetryChoice(const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    if (std::ranges::find(kWords, word) == std::end(kWords)) {
      const std::string_view near = dsl::DidYouMean(word, {std::begin(kWords), std::end(kWords)});
      throw CommandError(fmt::format("--retry {}: {}", word,
                                     near.empty()
                                         ? fmt::format("there are {}", fmt::join(kWords, ", "))
                                         : fmt::format("did you mean '{}'?", near)));
    }
    words_.insert(word);
  }
}

RetryChoice RetryChoice::Only(const std::string& run_id) {
  RetryChoice choice;
  choice.words_ = {run_id};
  return choice;
}

bool RetryChoice::Wants(const store::ResultFile& file, const store::ResultFile::Cell& cell,
                        const std::string& run_id) const {
  if (words_.contains(run_id) ||
      words_.contains(std::string(store::StatusName(file.ReadStatus(cell)))))
    return true;
  return words_.contains(std::string(kNoisy)) && file.Has("noise") &&
         file.ReadReal("noise", cell) == static_cast<double>(measure::Noise::kNoisy);
}

std::string RetryChoice::Text() const { return fmt::format("{}", fmt::join(words_, ",")); }

RetryChoice RetryChoice::FromText(const std::string& text) {
  RetryChoice choice;
  std::istringstream in(text);
  for (std::string word; std::getline(in, word, ',');)
    if (!word.empty()) choice.words_.insert(word);
  return choice;
}

RetryChoice RetryChoice::With(const RetryChoice& other) const {
  RetryChoice both = *this;
  both.words_.insert(other.words_.begin(), other.words_.end());
  return both;
}

}  // namespace cdb::cli
