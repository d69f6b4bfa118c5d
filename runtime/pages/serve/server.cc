#include "runtime/pages/serve/server.h"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "compiler/plan/input_file.h"
#include "compiler/schema/schema.h"
#include "runtime/editor/context.h"
#include "runtime/editor/server.h"
#include "runtime/editor/syntax_files.h"
#include "runtime/pages/page/page.h"
#include "runtime/pages/serve/http.h"
#include "runtime/pages/serve/text_edit.h"
#include "runtime/pages/view/scene_document.h"
#include "runtime/results/files/safe_file.h"
#include "runtime/results/store.h"

namespace cdb::serve {
namespace {

using Json = nlohmann::ordered_json;

std::string Dump(const Json& answer) {
  return answer.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json ParameterOf(const schema::Parameter& parameter, const std::string& text,
                 const std::string& benchmark, const std::string& group) {
  const std::string name(parameter.name);
  const auto written = WrittenValue(text, benchmark, {group, name});
  return {{"group", group},
          {"name", name},
          {"value", written ? Json(*written) : Json()},
          {"default", std::string(parameter.DefaultText())},
          {"takes", parameter.Takes()},
          {"unit", parameter.UnitText()},
          {"doc", std::string(parameter.doc)}};
}

/// Every row of the schema, for the world and for each group. Null if the text does not parse.
Json ParametersOf(const std::string& text, const std::string& benchmark) {
  Json parameters = Json::array();
  try {
    for (const schema::Parameter& parameter : schema::Schema())
      if (!parameter.grouped) parameters.push_back(ParameterOf(parameter, text, benchmark, ""));
    for (const std::string& group : GroupsIn(text, benchmark))
      for (const schema::Parameter& parameter : schema::Schema())
        if (parameter.grouped && parameter.NamedBlock().empty())
          parameters.push_back(ParameterOf(parameter, text, benchmark, group));
  } catch (const EditError&) {
    return nullptr;  // the diagnostics give the reason
  }
  return parameters;
}

/// A diagnostic at the name of the benchmark, or at the start of the text.
nlohmann::json DiagnosticAt(const editor::Analysis& analysis, const std::string& benchmark,
                            const std::string& message) {
  text::Span at = {&analysis.source(), 0, 0};
  for (const editor::Definition& each : analysis.symbols.definitions())
    if (each.kind == editor::SymbolKind::kBenchmark && each.name.source == &analysis.source() &&
        each.name.source->text().substr(each.name.begin, each.name.end - each.name.begin) ==
            benchmark)
      at = each.name;
  return {
      {"range", editor::RangeJson(at)}, {"severity", 1}, {"source", "cdb"}, {"message", message}};
}

std::string ReadWhole(const std::filesystem::path& file) {
  std::string why;
  return plan::ReadInputFile(file, why).value_or("");
}

Json Message(const std::string& message) { return {{"message", message}}; }

}  // namespace

namespace {

constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP};
std::atomic<pid_t> g_owner{0}, g_run{0};
static_assert(std::atomic<pid_t>::is_always_lock_free);

/// Calls only functions that are async-signal-safe.
void EndNow(int signal) {
  if (getpid() != g_owner.load()) _exit(128 + signal);  // a copy of this process that reads a file
  if (g_run.load() != 0) ::kill(-g_run.load(), SIGTERM);
  _exit(0);
}

/// While it lives, a signal that would end the program between two requests ends it at once, and
/// asks the run to stop: compiling a text takes up to minutes. Ignored signals stay ignored.
class EndsAtOnce {
 public:
  explicit EndsAtOnce(pid_t run) {
    g_owner = getpid();
    g_run = run;
    for (std::size_t i = 0; i < before_.size(); ++i) {
      sigaction(kSignals[i], nullptr, &before_[i]);
      if (before_[i].sa_handler == SIG_IGN) continue;
      struct sigaction action = {};
      action.sa_handler = EndNow;
      sigaction(kSignals[i], &action, nullptr);
    }
  }
  ~EndsAtOnce() {
    for (std::size_t i = 0; i < before_.size(); ++i) sigaction(kSignals[i], &before_[i], nullptr);
  }
  EndsAtOnce(const EndsAtOnce&) = delete;
  EndsAtOnce& operator=(const EndsAtOnce&) = delete;

 private:
  std::array<struct sigaction, std::size(kSignals)> before_{};
};

}  // namespace

Editor::Editor(Scenario scenario, std::filesystem::path program)
    : scenario_(std::move(scenario)), documents_(scenario_.compile), program_(std::move(program)) {
  // The path in place of a URI, so that names in messages are those of the user.
  documents_.Open({{"uri", scenario_.file.string()}, {"text", scenario_.text}});
}

Editor::~Editor() {
  // The first signal lets it finish its current run; the second ends it at once.
  for (int asked = 0; run_ != 0 && asked < 2; ++asked) {
    ::kill(-run_, SIGTERM);
    for (int waited = 0; waited < 20 && run_ != 0; ++waited) {
      if (::waitpid(run_, nullptr, WNOHANG) != 0) run_ = 0;
      if (run_ != 0) std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  }
}

std::shared_ptr<const editor::Analysis> Editor::Analyse(const std::string& text) {
  const EndsAtOnce ends(run_);
  const std::string uri = scenario_.file.string();
  editor::Document& document = *documents_.Find(uri);
  // Files that it uses may have changed, so only the questions about one text share an analysis.
  if (document.text != text) documents_.Change(uri, 0, {{{"text", text}}});
  return documents_.Analyse(document);
}

std::string Editor::Follow(const editor::Analysis& analysis) {
  const std::vector<std::string>& names = analysis.compilation.benchmarks;
  const auto place = [](const std::vector<std::string>& in, const std::string& name) {
    return static_cast<std::size_t>(std::ranges::find(in, name) - in.begin());
  };
  const std::string before = scenario_.benchmark;
  const std::size_t old = place(names_, before);
  if (names.empty() || !Parses(std::string(analysis.source().text()))) return {};
  names_ = names;
  if (place(names, before) < names.size()) return {};
  scenario_.benchmark = names[std::min(old, names.size() - 1)];
  return fmt::format("the text no longer has the benchmark '{}', so '{}' is shown", before,
                     scenario_.benchmark);
}

std::string Editor::SceneOf(const editor::Analysis& analysis, nlohmann::json& diagnostics) const {
  const EndsAtOnce ends(run_);
  try {
    const std::optional<plan::Plan> plan = editor::FirstRunOf(analysis, scenario_.benchmark);
    if (!plan) return {};
    view::SceneRecording start = view::StartOf(*plan, plan->runs.at(0));
    start.file = scenario_.file.string();
    return view::SceneDocument(plan->title.empty() ? plan->benchmark : plan->title, {&start, 1});
  } catch (const std::exception& error) {
    diagnostics.push_back(DiagnosticAt(analysis, scenario_.benchmark, error.what()));
    return {};
  }
}

std::string Editor::Check(const std::string& text) {
  const auto analysis = Analyse(text);
  nlohmann::json diagnostics = editor::DiagnosticsOf(*analysis);
  const std::string notice = Follow(*analysis);
  const std::vector<std::string>& names = analysis->compilation.benchmarks;
  if (names.empty() && !analysis->compilation.diagnostics.has_errors())
    diagnostics.push_back(
        DiagnosticAt(*analysis, "", "the text has no benchmark: nothing can be shown or run"));
  const std::string scene = SceneOf(*analysis, diagnostics);
  return Dump({{"text", text},
               {"benchmark", scenario_.benchmark},
               {"benchmarks", names},
               {"notice", notice},
               {"diagnostics", diagnostics},
               {"parameters", ParametersOf(text, scenario_.benchmark)},
               {"scene", scene.empty() ? Json() : Json::parse(scene)}});
}

std::string Editor::Complete(const std::string& text, const editor::Position& position) {
  const auto analysis = Analyse(text);
  return editor::Complete(*analysis, scenario_.file.string(),
                          editor::OffsetOf(analysis->source(), position), scenario_.library)
      .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string Editor::Hover(const std::string& text, const editor::Position& position) {
  const auto analysis = Analyse(text);
  return editor::HoverAt(*analysis, editor::OffsetOf(analysis->source(), position))
      .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string Editor::Document() {
  Json answer = Json::parse(Check(scenario_.text));
  Json document = answer["scene"].is_null()
                      ? Json{{"title", scenario_.benchmark}, {"runs", Json::array()}}
                      : answer["scene"];
  answer.erase("scene");
  answer["file"] = scenario_.file.string();
  answer["vocabulary"] = Json::parse(editor::VocabularyJson());
  document["editor"] = std::move(answer);
  return Dump(document);
}

std::string Editor::Set(const std::string& text, const std::string& group, const std::string& name,
                        const std::string& value) {
  try {
    return Check(WithValue(text, scenario_.benchmark, {group, name}, value));
  } catch (const EditError& error) {
    return Dump(Message(error.what()));
  }
}

std::string Editor::SaveFile(const std::string& text) {
  if (ReadWhole(scenario_.file) != scenario_.text)
    return fmt::format(
        "{} was changed by another program, so it was not saved: copy your text, then open the "
        "page again",
        scenario_.file.string());
  files::WriteWhole(text, scenario_.file);
  scenario_.text = text;
  return {};
}

std::string Editor::Save(const std::string& text) {
  const std::string why = SaveFile(text);
  return Dump(Message(why.empty() ? fmt::format("saved {}", scenario_.file.string()) : why));
}

std::string Editor::Run(const std::string& text) {
  if (run_ != 0) return Dump(Message("it is already running"));
  const auto analysis = Analyse(text);
  if (const int errors = analysis->compilation.diagnostics.error_count(); errors > 0)
    return Dump(Message(fmt::format("not run and not saved: the text has {} error{}", errors,
                                    errors == 1 ? "" : "s")));
  if (analysis->compilation.benchmarks.empty())
    return Dump(Message("not run and not saved: the text has no benchmark"));
  Follow(*analysis);
  if (const std::string why = SaveFile(text); !why.empty()) return Dump(Message(why));
  log_ = process::MemoryFile("cdb run");
  process::SpawnPlan spawn;
  spawn.Give(log_->get(), STDERR_FILENO);
  run_benchmark_ = scenario_.benchmark;
  run_ = spawn.Start(program_, {"run", scenario_.file.string(), "-b", run_benchmark_, "-o",
                                run_benchmark_ + ".view.h5", "--fresh"});
  return Dump(Message("running"));
}

std::string Editor::ResultScene() const {
  const results::ResultFile file(run_benchmark_ + ".view.h5");
  view::SceneRecording run = view::ReadRecording(file, view::DefaultCell(file), {});
  run.file = run_benchmark_ + ".view.h5";
  return view::SceneDocument(file.title().empty() ? file.benchmark() : file.title(), {&run, 1});
}

std::string Editor::Progress() {
  if (!log_) return Dump({{"is_running", false}, {"log", ""}});
  std::string log;
  std::array<char, 4096> part{};
  for (ssize_t n = 0;
       (n = ::pread(log_->get(), part.data(), part.size(), static_cast<off_t>(log.size()))) > 0;)
    log.append(part.data(), static_cast<std::size_t>(n));
  Json answer = {{"is_running", true}, {"log", log}};
  if (run_ == 0 || ::waitpid(run_, &run_status_, WNOHANG) == 0) {
    answer["is_running"] = run_ != 0;
    return Dump(answer);
  }
  run_ = 0;
  answer["is_running"] = false;
  const int status = WIFEXITED(run_status_) ? WEXITSTATUS(run_status_) : -1;
  if (status != 0) answer["log"] = log + "cdb run " + process::EndText(run_status_) + "\n";
  if (status == 0 || status == 3) try {
      answer["scene"] = Json::parse(ResultScene());
    } catch (const std::exception& error) {
      answer["log"] = log + error.what() + "\n";
    }
  return Dump(answer);
}

std::string Editor::Stop() {
  if (run_ != 0) ::kill(-run_, SIGTERM);
  return Dump(Message(run_ != 0 ? "stopping" : "nothing is running"));
}

namespace {

/// Reads a question: an object of a few texts and numbers. Throws nlohmann::json::exception, or
/// QuestionError if it is nested or large, which would take many times the memory of its text.
struct QuestionError : std::runtime_error {
  using std::runtime_error::runtime_error;
};
nlohmann::json ParseQuestion(const std::string& body) {
  constexpr int kDeepest = 2, kMostValues = 20;
  int values = 0;
  return nlohmann::json::parse(
      body, [&](int depth, nlohmann::json::parse_event_t, const nlohmann::json&) {
        if (depth > kDeepest || ++values > 3 * kMostValues)
          throw QuestionError("a question is an object of a few texts and numbers");
        return true;
      });
}

Reply Refusal(const char* why) {
  return {400, "text/plain; charset=utf-8", fmt::format("{}\n", why)};
}

/// Takes JSON and answers in JSON.
template <typename Act>
Route Answer(Editor& editor, const char* name, Act act) {
  return {"POST", name, [&editor, act](const std::string& body) -> Reply {
            try {
              const nlohmann::json question = ParseQuestion(body);
              if (question.contains("benchmark")) editor.Choose(question.at("benchmark"));
              return {.body = act(editor, question)};
            } catch (const nlohmann::json::exception& error) {
              return Refusal(error.what());
            } catch (const QuestionError& error) {
              return Refusal(error.what());
            } catch (const std::exception& error) {
              return {.body = Dump(Message(error.what()))};
            }
          }};
}

Reply PageOf(Editor& editor) {
  try {
    return {.type = "text/html; charset=utf-8",
            .body = page::Assemble(page::EditTemplate(), "cdb view", editor.Document())};
  } catch (const std::exception& error) {
    return {500, "text/plain; charset=utf-8", fmt::format("{}\n", error.what())};
  }
}

using Question = nlohmann::json;

editor::Position PositionOf(const Question& asked) {
  return {editor::NumberIn(asked, "line"), editor::NumberIn(asked, "character")};
}

}  // namespace

void Serve(Editor& editor, int stop_fd, const std::function<void(const std::string&)>& begin) {
  HttpServer server({
      {"GET", "", [&](const std::string&) { return PageOf(editor); }},
      Answer(editor, "check",
             [](Editor& e, const Question& asked) { return e.Check(asked.at("text")); }),
      Answer(editor, "set",
             [](Editor& e, const Question& asked) {
               return e.Set(asked.at("text"), asked.at("group"), asked.at("name"),
                            asked.at("value"));
             }),
      Answer(editor, "complete",
             [](Editor& e, const Question& asked) {
               return e.Complete(asked.at("text"), PositionOf(asked));
             }),
      Answer(editor, "hover",
             [](Editor& e, const Question& asked) {
               return e.Hover(asked.at("text"), PositionOf(asked));
             }),
      Answer(editor, "save",
             [](Editor& e, const Question& asked) { return e.Save(asked.at("text")); }),
      Answer(editor, "run",
             [](Editor& e, const Question& asked) { return e.Run(asked.at("text")); }),
      Answer(editor, "progress", [](Editor& e, const Question&) { return e.Progress(); }),
      Answer(editor, "stop", [](Editor& e, const Question&) { return e.Stop(); }),
  });
  begin(server.Address());
  server.Run(stop_fd);
}

}  // namespace cdb::serve
