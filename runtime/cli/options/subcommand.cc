#include "runtime/cli/options/subcommand.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <utility>

#include "dsl/diagnostics.h"

namespace cdb::options {

std::string Suggestion(std::string_view word, const std::vector<std::string_view>& known,
                       std::string otherwise) {
  const std::string_view near = dsl::DidYouMean(word, known);
  return near.empty() ? std::move(otherwise) : fmt::format("did you mean '{}'?", near);
}

Subcommand::Subcommand(CLI::App& program, const Command& row, ExitStatus& status)
    : program_(program), command_(*program.add_subcommand(row.name, row.help)), status_(status) {}

void Subcommand::Required(const std::string& name, std::string& value, const std::string& help) {
  command_.add_option(name, value, help)->required();
}

void Subcommand::Required(const std::string& name, std::vector<std::string>& values,
                          const std::string& help) {
  command_.add_option(name, values, help)->required();
}

void Subcommand::Optional(const std::string& name, std::string& value, const std::string& help) {
  command_.add_option(name, value, help);
}

void Subcommand::Optional(const std::string& name, std::vector<std::string>& values,
                          const std::string& help) {
  command_.add_option(name, values, help);
}

void Subcommand::List(const std::string& name, std::vector<std::string>& values,
                      const std::string& help) {
  command_.add_option(name, values, help)->delimiter(',');
}

void Subcommand::Repeated(const std::string& name, std::vector<std::string>& values,
                          const std::string& help) {
  command_.add_option(name, values, help)->allow_extra_args(false);
}

void Subcommand::ShortList(const std::string& name, std::vector<std::string>& values,
                           const std::string& help) {
  command_.add_option(name, values, help)->delimiter(',')->allow_extra_args(false);
}

void Subcommand::Count(const std::string& name, std::uint64_t& value, const std::string& help,
                       int least) {
  command_.add_option(name, value, help)->check(CLI::Range(least, 2147483647));
}

void Subcommand::Flag(const std::string& name, bool& value, const std::string& help) {
  command_.add_flag(name, value, help);
}

void Subcommand::Benchmark(std::optional<std::string>& benchmark) {
  const auto set = [&benchmark](const std::string& name) {
    if (!name.empty()) benchmark = name;
  };
  command_.add_option_function<std::string>("-b,--benchmark", set, "only this benchmark");
}

void Subcommand::Baseline(std::string& baseline) {
  Optional("--baseline", baseline,
           "detector that ratios are relative to (default: the first that has all cells)");
}

void Subcommand::Sound(bool& only_sound) {
  Flag("--sound", only_sound, "exclude runs whose verdict voids their timings");
}

void Subcommand::Retry(std::vector<std::string>& retry, const std::string& files) {
  ShortList(
      "--retry", retry,
      fmt::format("repeat such runs, in the same {}: failed, crashed, timed_out, noisy", files));
}

void Subcommand::RetryNoisy(std::uint64_t& retries) {
  Count("--retry-noisy", retries,
        "repeat a disturbed run at once, up to N times, and keep the quietest measurement");
}

void Subcommand::Out(std::string& out, const std::string& help) {
  command_.add_option("-o,--out", out, help);
}

void Subcommand::Jobs(std::uint64_t& jobs, const std::string& help) {
  command_.add_option("-j,--jobs", jobs, help)->check(CLI::Range(1, 4096));
}

void Subcommand::Fresh(bool& fresh, const std::string& help) {
  command_.add_flag("--fresh", fresh, help);
}

void Subcommand::Quiet(bool& quiet, const std::string& help) {
  command_.add_flag("-q,--quiet", quiet, help);
}

void Subcommand::Set(std::vector<std::string>& settings) {
  Repeated("--set", settings,
           "NAME=VALUE: set this parameter or let in every benchmark, over its own value "
           "(--set 'detector=sweep(sap, dbvt)'); repeat the option for several");
}

void Subcommand::Plugins(std::vector<std::string>& plugins) {
  command_
      .add_option("--plugin", plugins,
                  "shared library with your own detectors; each needs its own --plugin")
      ->allow_extra_args(false);
}

void Subcommand::Cycles(std::optional<std::uint64_t>& cycles, const std::string& help) {
  command_.add_option("--cycles", cycles, help)->check(CLI::Range(1, 2147483647));
}

void Subcommand::Action(std::function<ExitStatus()> action) {
  command_.callback([&status = status_, action = std::move(action)] { status = action(); });
}

}  // namespace cdb::options
