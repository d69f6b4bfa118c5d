#include "compiler/evaluate/convert.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compiler/scenario/diagnostic_kinds.h"
#include "compiler/schema/catalogue.h"

namespace cdb::evaluate {
namespace {

/// A distribution whose draws are this rarely inside the domain would be drawn again for ever.
constexpr double kLeastChance = 1e-3;

class Converter {
 public:
  Converter(const schema::Parameter& parameter, const dsl::Span& span,
            const std::vector<dsl::Span>& choices, std::span<const schema::PluginDetector> plugins,
            dsl::Diagnostics& diagnostics)
      : parameter_(parameter),
        span_(span),
        choices_(choices),
        plugins_(plugins),
        diagnostics_(diagnostics) {}

  std::optional<schema::Value> Constant(const Term& term) const {
    if (const schema::Word* word = term.word()) return FromWord(*word);
    if (const schema::Call* call = term.call())
      return parameter_.TakesCall(call->name) ? std::optional(schema::Value(*call))
                                              : WrongKind(term);
    using enum schema::ParameterType;
    switch (parameter_.type) {
      case kCount:
        return FromCount(term);
      case kReal:
        if (!term.number()) return WrongKind(term);
        if (!InDomain(term.number()->AsReal(), term.number()->Text())) return std::nullopt;
        return schema::Value(term.number()->AsReal());
      case kVector:
        return FromVector(term);
      case kRatio: {
        const auto* ratio = std::get_if<schema::Ratio>(&term.what);
        if (ratio == nullptr) return WrongKind(term);
        for (const double part : ratio->parts)
          if (!InDomain(part, schema::FormatReal(part))) return std::nullopt;
        return schema::Value(*ratio);
      }
      case kText:
        if (term.text()) return schema::Value(*term.text());
        break;
      case kSwitch:
      case kWord:
      case kWords:
        break;
    }
    return WrongKind(term);
  }

  std::optional<schema::Value> Drawn(const DrawnTerm& drawn) const {
    if (!parameter_.distribution)
      return Error(
          scenario::kWrongKind,
          fmt::format("'{}' has one value in a run and takes no distribution", parameter_.name),
          "sweep(…) makes a run for each of several values");
    schema::Distribution distribution{drawn.kind, {}, drawn.weights};
    if (drawn.kind == schema::DistributionKind::kAny) {
      bool good = true;
      for (std::size_t i = 0; i < drawn.arguments.size(); ++i) {
        const dsl::Span& at = i < choices_.size() ? choices_[i] : span_;
        if (drawn.arguments[i].call() && !parameter_.ChoosesCalls()) {
          diagnostics_.Report(scenario::kBadArguments, at,
                              fmt::format("{} goes on for the whole run and cannot be a choice "
                                          "of any( )",
                                          KindName(drawn.arguments[i])),
                              "sweep(…) makes a run for each of several");
          good = false;
          continue;
        }
        const auto value =
            Converter(parameter_, at, {}, {}, diagnostics_).Constant(drawn.arguments[i]);
        good = good && value;
        if (value) distribution.arguments.push_back(*value);
      }
      if (!good) return std::nullopt;
      return schema::Value(std::move(distribution));
    }
    const bool vectors = drawn.arguments[0].vector() != nullptr;
    if (parameter_.type != schema::ParameterType::kReal &&
        parameter_.type != schema::ParameterType::kVector)
      return Error(scenario::kWrongKind,
                   fmt::format("'{}' takes {}; {}( ) draws numbers", parameter_.name,
                               parameter_.Takes(plugins_), schema::DistributionName(drawn.kind)),
                   "any(…) draws from a list");
    if (vectors && parameter_.type != schema::ParameterType::kVector)
      return Error(
          scenario::kWrongKind,
          fmt::format("'{}' is a number and cannot be drawn from vectors", parameter_.name));
    if (!vectors && !Reachable(drawn)) return std::nullopt;
    for (const Term& argument : drawn.arguments) {
      if (vectors) {
        distribution.arguments.emplace_back(*argument.vector());
      } else {
        distribution.arguments.emplace_back(argument.number()->AsReal());
      }
    }
    return schema::Value(std::move(distribution));
  }

 private:
  std::nullopt_t Error(const dsl::DiagnosticKind& kind, std::string message,
                       std::string help = {}) const {
    diagnostics_.Report(kind, span_, std::move(message), std::move(help));
    return std::nullopt;
  }

  std::nullopt_t WrongKind(const Term& term) const {
    const schema::Text* text = term.text();
    if (text != nullptr &&
        (parameter_.HasWord(text->text, plugins_) || parameter_.TakesCall(text->text)))
      return Error(scenario::kWrongKind,
                   fmt::format("'{}' takes a word, not a text", parameter_.name),
                   fmt::format("write {} without quotes", text->text));
    return Error(scenario::kWrongKind,
                 fmt::format("'{}' takes {}; this is {}", parameter_.name,
                             parameter_.Takes(plugins_), KindName(term)),
                 text != nullptr && parameter_.TakesCall("mesh")
                     ? fmt::format("write mesh({})", ToText(schema::Value(*text)))
                     : "");
  }

  bool InDomain(double value, const std::string& text) const {
    if (parameter_.domain.Contains(value)) return true;
    Error(scenario::kOutOfDomain,
          fmt::format("'{}' must be {}, not {}", parameter_.name, parameter_.domain.Text(), text));
    return false;
  }

  std::optional<schema::Value> FromCount(const Term& term) const {
    if (!term.number()) return WrongKind(term);
    const auto whole = term.number()->AsWhole();
    if (!whole)
      return Error(scenario::kWrongKind, fmt::format("'{}' must be a whole number, not {}",
                                                     parameter_.name, term.number()->Text()));
    constexpr Integer kMost = ~std::uint64_t{0};
    if (*whole > kMost || !parameter_.domain.Contains(static_cast<double>(*whole)))
      return Error(scenario::kOutOfDomain,
                   *whole > 0 ? fmt::format("'{}' does not go up to {}", parameter_.name,
                                            term.number()->Text())
                              : fmt::format("'{}' must be {}, not {}", parameter_.name,
                                            parameter_.domain.Text(), term.number()->Text()));
    return schema::Value(static_cast<std::uint64_t>(*whole));
  }

  std::optional<schema::Value> FromVector(const Term& term) const {
    const auto not_zero = [this](const Eigen::Vector3d& vector) {
      if (!parameter_.domain.not_zero || !vector.isZero(0))
        return std::optional(schema::Value(vector));
      return std::optional<schema::Value>(
          Error(scenario::kOutOfDomain, fmt::format("'{}' must not be 0", parameter_.name)));
    };
    if (term.vector()) return not_zero(*term.vector());
    if (!term.number()) return WrongKind(term);
    if (term.number()->AsReal() != 0)
      return Error(
          scenario::kWrongKind,
          fmt::format("'{}' is a vector; of numbers only 0 stands for one", parameter_.name),
          fmt::format("write (0, {}, 0), say", term.number()->Text()));
    return not_zero(Eigen::Vector3d::Zero());
  }

  std::optional<schema::Value> FromWord(const schema::Word& word) const {
    const std::string& text = word.text;
    if (parameter_.type == schema::ParameterType::kSwitch) {
      if (text == "on" || text == "true") return schema::Value(true);
      if (text == "off" || text == "false") return schema::Value(false);
    }
    if (parameter_.TakesDetectors())
      if (const auto detector = schema::FindDetector(text, plugins_))
        return CanBeUsed(*detector) ? std::optional(schema::Value(word)) : std::nullopt;
    if (parameter_.HasWord(text)) return schema::Value(word);
    if (parameter_.TakesCall(text)) {
      const schema::ParametrisedWord& info = *schema::FindParametrisedWord(text);
      if (auto call = schema::WithDefaults(info)) return schema::Value(std::move(*call));
      ReportMissingArguments(info, schema::RequiredArguments(info), span_, diagnostics_);
      return std::nullopt;
    }
    std::vector<std::string_view> words = parameter_.AllWords(plugins_);
    for (const std::string_view call : parameter_.AllCalls()) words.push_back(call);
    if (parameter_.type == schema::ParameterType::kSwitch) words = {"on", "off"};
    if (words.empty())
      return Error(
          scenario::kUnknownName, fmt::format("'{}' cannot be '{}'", parameter_.name, text),
          fmt::format("it takes {}, and no let has this name", parameter_.Takes(plugins_)));
    const std::string_view near = dsl::DidYouMean(text, words);
    return Error(scenario::kUnknownName, fmt::format("'{}' cannot be '{}'", parameter_.name, text),
                 near.empty() ? fmt::format("it takes {}", parameter_.Takes(plugins_))
                              : fmt::format("did you mean '{}'?", near));
  }

  /// It has the phase that is asked for, and is there.
  bool CanBeUsed(const schema::DetectorInfo& detector) const {
    if (!parameter_.HasWord(detector.name, plugins_)) {
      if (parameter_.word_source == schema::WordSource::kNarrowPhases) {
        Error(scenario::kWrongKind,
              fmt::format("'{}' has no narrow phase: it finds pairs", detector.name),
              fmt::format("write detector {}", detector.name));
      } else {
        Error(scenario::kWrongKind,
              fmt::format("'{}' finds no pairs: it is a narrow phase", detector.name),
              fmt::format("write narrow_phase {}", detector.name));
      }
      return false;
    }
    const schema::DetectorPart* part = schema::FindDetectorPart(detector.part);
    if (part == nullptr || part->is_built) return true;
    Error(scenario::kUnavailable,
          fmt::format("'{}' is not part of this build: it needs the package {}", detector.name,
                      part->package),
          "`./setup --third-party` installs it and builds the detectors that need it");
    return false;
  }

  /// Draws outside the domain are drawn again; that has to end.
  bool Reachable(const DrawnTerm& drawn) const {
    const double a = drawn.arguments[0].number()->AsReal();
    const double b = drawn.arguments[1].number()->AsReal();
    const schema::Domain& domain = parameter_.domain;
    double chance = 0;
    if (a == b || (drawn.kind == schema::DistributionKind::kNormal && b == 0)) {
      chance = domain.Contains(a) ? 1 : 0;
    } else if (drawn.kind == schema::DistributionKind::kNormal) {
      const auto below = [&](double x) { return 0.5 * std::erfc((a - x) / (b * std::sqrt(2.0))); };
      chance = below(domain.max) - below(domain.min);
    } else {
      const bool log = drawn.kind == schema::DistributionKind::kLogUniform;
      const auto scale = [log](double x) { return log ? std::log(x) : x; };
      const double low = std::max(a, domain.min), high = std::min(b, domain.max);
      chance = low < high ? (scale(high) - scale(low)) / (scale(b) - scale(a)) : 0;
    }
    if (chance >= kLeastChance) return true;
    Error(scenario::kOutOfDomain,
          fmt::format("'{}' must be {}; {} {} is", parameter_.name, domain.Text(),
                      ToText(Term{drawn}), chance > 0 ? "hardly ever" : "never"),
          "what is outside is drawn again, so most of it has to lie inside");
    return false;
  }

  const schema::Parameter& parameter_;
  const dsl::Span& span_;
  const std::vector<dsl::Span>& choices_;
  std::span<const schema::PluginDetector> plugins_;
  dsl::Diagnostics& diagnostics_;
};

}  // namespace

std::optional<schema::Value> Convert(const Term& term, const schema::Parameter& parameter,
                                     const dsl::Span& span, const std::vector<dsl::Span>& choices,
                                     std::span<const schema::PluginDetector> plugins,
                                     dsl::Diagnostics& diagnostics) {
  const Converter converter(parameter, span, choices, plugins, diagnostics);
  return term.drawn() ? converter.Drawn(*term.drawn()) : converter.Constant(term);
}

void ReportMissingArguments(const schema::ParametrisedWord& info,
                            const std::vector<std::string_view>& missing, const dsl::Span& span,
                            dsl::Diagnostics& diagnostics) {
  std::string usage;
  for (const std::string_view name : schema::RequiredArguments(info))
    usage += fmt::format("{}{}: …", usage.empty() ? "" : ", ", name);
  diagnostics.Report(scenario::kBadArguments, span,
                     fmt::format("'{}' needs {}", info.name, fmt::join(missing, ", ")),
                     fmt::format("write {}({})", info.name, usage));
}

std::optional<schema::Value> ConvertList(const std::vector<std::pair<Term, dsl::Span>>& terms,
                                         const schema::Parameter& parameter,
                                         dsl::Diagnostics& diagnostics) {
  schema::WordList words;
  std::vector<dsl::Span> spans;
  bool good = true;
  for (const auto& [term, span] : terms) {
    const auto value = Converter(parameter, span, {}, {}, diagnostics).Constant(term);
    if (!value) {
      good = false;
      continue;
    }
    const std::string& word = std::get<schema::Word>(*value).text;
    if (std::ranges::find(words, word) != words.end()) {
      diagnostics.Report(scenario::kSetTwice, span,
                         fmt::format("'{}' is in the list already", word), "keep one of them");
      good = false;
    }
    words.push_back(word);
    spans.push_back(span);
  }
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (!parameter.StandsAlone(words[i])) continue;
    // Of two words that both want to stand alone, the second is the odd one.
    for (std::size_t j = 0; j < words.size(); ++j) {
      if (words[j] == words[i] || (parameter.StandsAlone(words[j]) && i < j)) continue;
      diagnostics.Report(scenario::kContradiction, spans[i],
                         fmt::format("'{}' cannot stand beside '{}'", words[i], words[j]),
                         fmt::format("'{}' speaks of all of them: write it alone, or only the "
                                     "others",
                                     words[i]));
      good = false;
      break;
    }
  }
  if (!good) return std::nullopt;
  // Order has no meaning, so it must not make another run of it.
  std::ranges::sort(words);
  return schema::Value(std::move(words));
}

}  // namespace cdb::evaluate
