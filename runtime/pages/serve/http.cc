#include "runtime/pages/serve/http.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <map>
#include <optional>
#include <random>
#include <system_error>
#include <utility>

namespace cdb::serve {
namespace {

constexpr const char* kLoopback = "127.0.0.1";
/// After a refusal, bytes that the client still sends are read for this time, because a closed
/// connection with unread bytes would lose the reply.
constexpr std::chrono::milliseconds kLinger{1'000};
constexpr std::string_view kEndOfHead = "\r\n\r\n";

std::string MakeToken() {
  std::random_device device;  // of the processor or the operating system
  std::string token;
  for (int i = 0; i < 4; ++i) token += fmt::format("{:08x}", device());
  return token;
}

std::string_view ReasonOf(int status) {
  switch (status) {
    case 200:
      return "OK";
    case 400:
      return "Bad Request";
    case 403:
      return "Forbidden";
    case 404:
      return "Not Found";
    case 405:
      return "Method Not Allowed";
    case 411:
      return "Length Required";
    case 413:
      return "Content Too Large";
    case 415:
      return "Unsupported Media Type";
    case 431:
      return "Request Header Fields Too Large";
    case 501:
      return "Not Implemented";
    default:
      return "Internal Server Error";
  }
}

std::string LowerCase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return lower;
}

std::string_view Trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

[[noreturn]] void FailToListen() {
  throw std::system_error(errno, std::generic_category(), "no port of the loopback interface");
}

}  // namespace

struct HttpServer::Head {
  std::string method, path;
  std::map<std::string, std::string> fields;  ///< by their names in lower case

  /// Nullopt if it is malformed, or has a field twice. `text` ends before the empty line.
  static std::optional<Head> Parse(std::string_view text) {
    Head head;
    std::size_t end = std::min(text.find("\r\n"), text.size());
    const std::string_view line = text.substr(0, end);
    const std::size_t first = line.find(' '), last = line.rfind(' ');
    if (first == line.npos || line.find(' ', first + 1) != last || first == last)
      return std::nullopt;
    const std::string_view version = line.substr(last + 1);
    if (version != "HTTP/1.1" && version != "HTTP/1.0") return std::nullopt;
    head.method = line.substr(0, first);
    head.path = line.substr(first + 1, last - first - 1);
    while (end < text.size()) {
      const std::size_t begin = end + 2;
      end = std::min(text.find("\r\n", begin), text.size());
      const std::string_view field = text.substr(begin, end - begin);
      const std::size_t colon = field.find(':');
      if (colon == field.npos || colon == 0 || field.find_first_of(" \t") < colon)
        return std::nullopt;
      if (!head.fields.emplace(LowerCase(field.substr(0, colon)), Trimmed(field.substr(colon + 1)))
               .second)
        return std::nullopt;
    }
    return head;
  }
  std::string FieldOf(const char* name) const {
    const auto found = fields.find(name);
    return found == fields.end() ? std::string() : found->second;
  }
};

enum class Stage { kReading, kWriting, kLingering, kDone };

struct HttpServer::Connection {
  plan::Descriptor socket;
  Clock::time_point deadline;
  Stage stage = Stage::kReading;
  std::string in = {}, out = {};
  std::size_t sent = 0;
  const Route* route = nullptr;  ///< null until the head is complete
  std::size_t body_bytes = 0;
  bool lingers = false;  ///< the client may still be sending
};

HttpServer::HttpServer(std::vector<Route> routes, const HttpLimits& limits)
    : routes_(std::move(routes)),
      limits_(limits),
      token_(MakeToken()),
      listener_(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  ::inet_pton(AF_INET, kLoopback, &address.sin_addr);
  socklen_t size = sizeof address;
  auto* any = reinterpret_cast<sockaddr*>(&address);
  if (listener_.get() < 0 || ::bind(listener_.get(), any, size) != 0 ||
      ::listen(listener_.get(), SOMAXCONN) != 0 || ::getsockname(listener_.get(), any, &size) != 0)
    FailToListen();
  port_ = ntohs(address.sin_port);
}

HttpServer::~HttpServer() = default;

std::string HttpServer::Address() const {
  return fmt::format("http://{}:{}/{}/", kLoopback, port_, token_);
}

void HttpServer::Run(int stop_fd) {
  for (;;) {
    std::vector<pollfd> waited = {{stop_fd, POLLIN, 0}, {listener_.get(), POLLIN, 0}};
    auto soonest = Clock::time_point::max();
    for (const Connection& each : connections_) {
      waited.push_back({each.socket.get(),
                        static_cast<short>(each.stage == Stage::kWriting ? POLLOUT : POLLIN), 0});
      soonest = std::min(soonest, each.deadline);
    }
    int timeout = -1;
    if (!connections_.empty())
      timeout = static_cast<int>(std::max<std::int64_t>(
          0, std::chrono::ceil<std::chrono::milliseconds>(soonest - Clock::now()).count()));
    if (::poll(waited.data(), waited.size(), timeout) < 0 && errno != EINTR)
      throw std::system_error(errno, std::generic_category(), "poll");
    if (waited[0].revents != 0) return;
    // An answer takes time in which the other requests must not expire unread.
    const Clock::time_point now = Clock::now();
    std::size_t i = 2;
    for (Connection& each : connections_) {
      const short events = waited[i++].revents;
      if (events == 0) {
        if (each.deadline <= now) each.stage = Stage::kDone;
      } else if (each.stage == Stage::kWriting) {
        Write(each);
      } else {
        Read(each);
        pollfd stop = {stop_fd, POLLIN, 0};
        if (::poll(&stop, 1, 0) > 0) return;
      }
    }
    connections_.remove_if([](const Connection& each) { return each.stage == Stage::kDone; });
    if (waited[1].revents != 0) Accept();
  }
}

void HttpServer::Accept() {
  for (;;) {
    plan::Descriptor socket(
        ::accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (socket.get() < 0) {
      if (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM) DropOldest();
      return;
    }
    if (connections_.size() >= limits_.connections) DropOldest();
    connections_.push_back(
        {.socket = std::move(socket), .deadline = Clock::now() + limits_.reading});
  }
}

void HttpServer::DropOldest() {
  auto oldest = std::ranges::find_if(
      connections_, [](const Connection& each) { return each.stage != Stage::kWriting; });
  if (oldest == connections_.end()) oldest = connections_.begin();
  if (oldest != connections_.end()) connections_.erase(oldest);
}

void HttpServer::Read(Connection& connection) {
  char bytes[1 << 16];
  const ssize_t count = ::recv(connection.socket.get(), bytes, sizeof bytes, 0);
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (count <= 0) {
    connection.stage = Stage::kDone;
    return;
  }
  if (connection.stage == Stage::kLingering) return;  // they are dropped
  connection.in.append(bytes, static_cast<std::size_t>(count));
  if (connection.route == nullptr) {
    const std::size_t end = connection.in.find(kEndOfHead);
    if (std::min(end, connection.in.size()) > limits_.head)
      return Refuse(connection, 431,
                    fmt::format("the head of a request has at most {} bytes", limits_.head));
    if (end == std::string::npos) return;
    TakeHead(connection, end);
    if (connection.route == nullptr) return;
  }
  if (connection.in.size() > connection.body_bytes)
    return Refuse(connection, 400, "the body is longer than its Content-Length");
  if (connection.in.size() == connection.body_bytes) Answer(connection);
}

void HttpServer::TakeHead(Connection& connection, std::size_t end) {
  const auto refuse = [&](int status, std::string_view why) { Refuse(connection, status, why); };
  const std::optional<Head> head = Head::Parse(std::string_view(connection.in).substr(0, end));
  if (!head) return refuse(400, "this is not a request of HTTP/1.1");
  // The browser treats another host name for this machine as another site.
  if (head->FieldOf("host") != fmt::format("{}:{}", kLoopback, port_))
    return refuse(403, "the host has another name");
  const std::string prefix = "/" + token_ + "/";
  if (!head->path.starts_with(prefix)) return refuse(404, "there is no such page");
  const auto route = std::ranges::find_if(
      routes_, [&](const Route& each) { return prefix + each.name == head->path; });
  if (route == routes_.end()) return refuse(404, "there is no such page");
  if (route->method != head->method)
    return refuse(405, fmt::format("this page takes {} only", route->method));
  if (head->fields.contains("transfer-encoding"))
    return refuse(
        501, "a body in chunks is not read: send Content-Length in place of Transfer-Encoding");
  if (head->fields.contains("content-encoding"))
    return refuse(415, "a compressed body is not read: send it without Content-Encoding");
  const std::string length = head->FieldOf("content-length");
  if (length.empty() && route->method == "POST")
    return refuse(411, "the request has no Content-Length");
  std::size_t bytes = 0;
  if (!length.empty()) {
    const auto [rest, error] = std::from_chars(length.data(), length.data() + length.size(), bytes);
    if (error == std::errc::result_out_of_range)
      bytes = limits_.body + 1;
    else if (error != std::errc() || rest != length.data() + length.size())
      return refuse(400, "the Content-Length is not a number");
  }
  if (bytes > limits_.body)
    return refuse(413, fmt::format("a body has at most {} bytes", limits_.body));
  connection.route = &*route;
  connection.body_bytes = bytes;
  connection.in.erase(0, end + kEndOfHead.size());
  // A client that asks first waits for this; there is room for it in the buffer of a new
  // connection.
  if (LowerCase(head->FieldOf("expect")) == "100-continue" && connection.in.empty() && bytes > 0)
    (void)::send(connection.socket.get(), "HTTP/1.1 100 Continue\r\n\r\n", 25, MSG_NOSIGNAL);
}

void HttpServer::Answer(Connection& connection) {
  const std::string body = std::exchange(connection.in, {});
  Send(connection, connection.route->answer(body));
}

void HttpServer::Refuse(Connection& connection, int status, std::string_view why) {
  connection.lingers = true;
  connection.in = {};
  Send(connection, {status, "text/plain; charset=utf-8", fmt::format("{}\n", why)});
}

void HttpServer::Send(Connection& connection, const Reply& reply) {
  connection.out = fmt::format(
      "HTTP/1.1 {} {}\r\nContent-Type: {}\r\nContent-Length: {}\r\nConnection: "
      "close\r\nCache-Control: no-store\r\n"
      "Referrer-Policy: no-referrer\r\nX-Frame-Options: DENY\r\nX-Content-Type-Options: "
      "nosniff\r\n\r\n",
      reply.status, ReasonOf(reply.status), reply.type, reply.body.size());
  connection.out += reply.body;
  connection.stage = Stage::kWriting;
  connection.deadline = Clock::now() + limits_.writing;
  Write(connection);
}

void HttpServer::Write(Connection& connection) {
  while (connection.sent < connection.out.size()) {
    const ssize_t count = ::send(connection.socket.get(), connection.out.data() + connection.sent,
                                 connection.out.size() - connection.sent, MSG_NOSIGNAL);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno == EAGAIN) return;
    if (count < 0) {
      connection.stage = Stage::kDone;
      return;
    }
    connection.sent += static_cast<std::size_t>(count);
  }
  connection.out = {};
  ::shutdown(connection.socket.get(), SHUT_WR);
  connection.stage = connection.lingers ? Stage::kLingering : Stage::kDone;
  connection.deadline = Clock::now() + kLinger;
}

}  // namespace cdb::serve
