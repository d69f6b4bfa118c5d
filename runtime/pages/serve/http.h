// A small HTTP/1.1 server on the loopback interface, in one thread.
//
// Each start has a random port and a random token of 128 bits, which is part of every path, so that
// neither other users of the machine nor pages of other sites can reach it. A head is checked
// before its body is read. All connections are read side by side, each with a deadline; complete
// requests are answered one at a time.
//
// Errors: std::system_error if no port is available. Not thread-safe. Source: RFC 9112.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <list>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/plan/input_file.h"

namespace cdb::serve {

struct Reply {
  int status = 200;
  std::string type = "application/json", body;
};

struct Route {
  std::string method;                                    ///< GET or POST
  std::string name;                                      ///< the path after the token; may be empty
  std::function<Reply(const std::string& body)> answer;  ///< must not throw
};

/// Larger heads, bodies and numbers of connections are refused; a connection over its time is
/// closed.
struct HttpLimits {
  std::size_t head = 16'000, body = 4'000'000;  ///< bytes
  std::size_t connections = 64;  ///< beyond that, the oldest that still sends its request is closed
  std::chrono::milliseconds reading{15'000}, writing{60'000};
};

class HttpServer {
 public:
  explicit HttpServer(std::vector<Route> routes, const HttpLimits& limits = {});
  ~HttpServer();

  /// `http://127.0.0.1:PORT/TOKEN/`. Connections are accepted from the constructor on.
  std::string Address() const;
  /// Serves until `stop_fd` is readable.
  void Run(int stop_fd);

 private:
  using Clock = std::chrono::steady_clock;
  struct Connection;
  struct Head;

  void Accept();
  void DropOldest();
  void Read(Connection& connection);
  void TakeHead(Connection& connection, std::size_t end);
  void Answer(Connection& connection);
  void Refuse(Connection& connection, int status, std::string_view why);
  void Send(Connection& connection, const Reply& reply);
  void Write(Connection& connection);

  const std::vector<Route> routes_;
  const HttpLimits limits_;
  const std::string token_;
  plan::Descriptor listener_;
  int port_ = 0;
  std::list<Connection> connections_;  ///< oldest first
};

}  // namespace cdb::serve
