#include "runtime/cli/options/browser.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spawn.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string_view>
#include <system_error>

#include "dsl/text/utf8.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/sweep/process/program.h"

extern char** environ;

namespace cdb::options {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDrawing[] = {"chromium",       "chromium-browser",
                                    "google-chrome",  "google-chrome-stable",
                                    "microsoft-edge", "brave-browser"};

std::string EnvironmentText(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

/// The words of a command with the address in place of `%s`, or at the end.
std::vector<std::string> WordsOf(const std::string& command, const std::string& address) {
  std::istringstream text(command);
  std::vector<std::string> words;
  bool has_place = false;
  for (std::string word; text >> word;) {
    if (const std::size_t at = word.find("%s"); at != std::string::npos) {
      word.replace(at, 2, address);
      has_place = true;
    }
    words.push_back(word);
  }
  if (!has_place) words.push_back(address);
  return words;
}

/// Starts a program in a session of its own, which outlives this process. False if it cannot.
bool Launch(const std::vector<std::string>& words) {
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_init(&actions);
  posix_spawnattr_init(&attributes);
  for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&actions, fd, "/dev/null", O_RDWR, 0);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID);
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  pid_t pid = -1;
  const int error = posix_spawnp(&pid, argv[0], &actions, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return error == 0;
}

/// A folder of settings, so that neither the reader's own settings nor an open window matter.
class BrowserProfile {
 public:
  BrowserProfile() {
    std::string name = (fs::temp_directory_path() / "cdb-browser-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr)
      throw CommandError(fmt::format("cannot make a folder in {}: {}",
                                     fs::temp_directory_path().string(),
                                     std::generic_category().message(errno)));
    path_ = name;
  }
  ~BrowserProfile() {
    std::error_code error;
    fs::remove_all(path_, error);
  }
  BrowserProfile(const BrowserProfile&) = delete;
  BrowserProfile& operator=(const BrowserProfile&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

std::string RequireDrawing() {
  const auto* found = std::ranges::find_if(
      kDrawing, [](const char* name) { return process::FindProgram(name).has_value(); });
  if (found == std::end(kDrawing))
    throw CommandError(fmt::format(
        "--svg needs a browser that runs without a window, because scripts of the page draw its "
        "figures; PATH has none of {}. Install one (as root `apt-get install chromium`), or save "
        "figures from the page in another browser",
        fmt::join(kDrawing, ", ")));
  return *found;
}

/// A name that a page gives to a figure. A page holds text of results files of others.
bool IsFigureName(std::string_view name) {
  return name.ends_with(".svg") && name.size() < 200 &&
         std::ranges::all_of(name.substr(0, name.size() - 4), [](unsigned char c) {
           return std::isalnum(c) != 0 || c == '-' || c == '_';
         });
}

/// What follows `#` in the address of a page that shall draw its figures.
std::string FragmentOf(const FigureChoices& choices) {
  constexpr std::string_view kSizes[] = {"screen", "column", "page"};
  constexpr int kLeastWidth = 40, kMostWidth = 1000;
  const std::string& size = choices.size;
  const bool is_width = size.ends_with("mm") && size.size() <= 6 &&
                        std::all_of(size.begin(), size.end() - 2,
                                    [](unsigned char c) { return std::isdigit(c) != 0; });
  const int width = is_width ? std::atoi(size.c_str()) : kLeastWidth;
  if ((!is_width && std::ranges::find(kSizes, size) == std::end(kSizes)) || width < kLeastWidth ||
      width > kMostWidth)
    throw CommandError(
        fmt::format("--size cannot be '{}'; it is one of {}, or a width from {}mm to {}mm", size,
                    fmt::join(kSizes, ", "), kLeastWidth, kMostWidth));
  std::string_view view = choices.view;
  if (view.starts_with('#')) view.remove_prefix(1);
  const auto is_of_address = [](unsigned char c) {
    return std::isalnum(c) != 0 ||
           std::string_view("-_.~%=&:+!*'()").find(c) != std::string_view::npos;
  };
  if (!std::ranges::all_of(view, is_of_address))
    throw CommandError(fmt::format(
        "--view takes what the address of the page has after #, such as quantity=time:broad, not "
        "'{}'",
        choices.view));
  return fmt::format("#figures&size={}&{}", choices.size, view);
}

/// The text of the element that a page with such an address consists of.
std::string_view FiguresIn(std::string_view html) {
  constexpr std::string_view kStart = "<pre id=\"figures\">";
  const std::size_t start = html.rfind(kStart);
  if (start == std::string_view::npos) return {};
  html.remove_prefix(start + kStart.size());
  return html.substr(0, html.find("</pre>"));
}

}  // namespace

std::string AddressOf(const fs::path& page) {
  std::string address = "file://";
  for (const char c : fs::absolute(page).lexically_normal().string()) {
    const bool is_plain = std::isalnum(static_cast<unsigned char>(c)) != 0 ||
                          std::string_view("/-._~").find(c) != std::string_view::npos;
    address += is_plain
                   ? std::string(1, c)
                   : fmt::format("%{:02X}", static_cast<unsigned>(static_cast<unsigned char>(c)));
  }
  return address;
}

std::string OpenInBrowser(const fs::path& page) {
  const std::string address = AddressOf(page);
  std::istringstream own(EnvironmentText("BROWSER"));
  for (std::string command; std::getline(own, command, ':');)
    if (const auto words = WordsOf(command, address); words.size() > 1 && Launch(words))
      return words[0];
  const bool has_display =
      !EnvironmentText("DISPLAY").empty() || !EnvironmentText("WAYLAND_DISPLAY").empty();
  if (has_display && Launch({"xdg-open", address})) return "xdg-open";
  return {};
}

std::vector<std::pair<std::string, std::string>> DrawFigures(const fs::path& page,
                                                             const FigureChoices& choices) {
  const std::string fragment = FragmentOf(choices);
  const std::string browser = RequireDrawing();
  const BrowserProfile profile;
  std::vector<std::string> words = {browser,
                                    "--headless",
                                    "--disable-gpu",
                                    "--no-first-run",
                                    "--font-render-hinting=none",
                                    "--user-data-dir=" + profile.path().string(),
                                    "--virtual-time-budget=60000",
                                    "--dump-dom",
                                    AddressOf(page) + fragment};
  // Chromium refuses to confine itself as root.
  if (geteuid() == 0) words.insert(words.begin() + 1, "--no-sandbox");
  const auto end = process::RunProgram(words, "");
  const auto json = nlohmann::ordered_json::parse(end ? FiguresIn(end->out) : "", nullptr, false);
  if (!json.is_object())
    throw CommandError(fmt::format("{} did not draw the figures of {}{}", browser, page.string(),
                                   end ? fmt::format(" (exit status {})", end->status) : ""));
  if (const auto unknown = json.find("unknown"); unknown != json.end() && unknown->is_string())
    throw CommandError(
        fmt::format("--view: no figure takes '{}'; choose the view on the page, and copy what its "
                    "address then has after #",
                    text::Printable(unknown->get<std::string>())));
  std::vector<std::pair<std::string, std::string>> drawn;
  for (const auto& [name, svg] : json.items())
    if (svg.is_string() && IsFigureName(name)) drawn.emplace_back(name, svg.get<std::string>());
  return drawn;
}

}  // namespace cdb::options
