// A client on a plain socket, which may break every rule of HTTP.
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <string>
#include <string_view>

#include "compiler/plan/input_file.h"

namespace cdb::tests {

/// `http://127.0.0.1:PORT/TOKEN/`
struct Address {
  explicit Address(const std::string& url) {
    const std::size_t host_begin = url.find("//") + 2, path_begin = url.find('/', host_begin);
    host = url.substr(host_begin, path_begin - host_begin);
    path = url.substr(path_begin, url.find('/', path_begin + 1) - path_begin + 1);
    port = std::stoi(host.substr(host.find(':') + 1));
  }
  std::string host, path;
  int port = 0;
};

class RawClient {
 public:
  explicit RawClient(const Address& address)
      : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in to = {};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(address.port));
    ::inet_pton(AF_INET, "127.0.0.1", &to.sin_addr);
    EXPECT_EQ(::connect(socket_.get(), reinterpret_cast<sockaddr*>(&to), sizeof to), 0);
  }

  /// False if the server has closed the connection.
  bool Send(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t count = ::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (count <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(count));
    }
    return true;
  }
  /// Everything until the server closes the connection.
  std::string ReadAll() {
    std::string all;
    char bytes[1 << 16];
    for (ssize_t count = 0; (count = ::recv(socket_.get(), bytes, sizeof bytes, 0)) > 0;)
      all.append(bytes, static_cast<std::size_t>(count));
    return all;
  }
  std::string Ask(std::string_view request) {
    Send(request);
    return ReadAll();
  }
  int fd() const { return socket_.get(); }

 private:
  plan::Descriptor socket_;
};

/// `200`, or empty.
inline std::string StatusOf(const std::string& reply) {
  return reply.starts_with("HTTP/1.1 ") ? reply.substr(9, 3) : std::string();
}
inline std::string BodyOf(const std::string& reply) {
  const std::size_t end = reply.find("\r\n\r\n");
  return end == reply.npos ? std::string() : reply.substr(end + 4);
}

inline std::string Post(const Address& address, const std::string& name, const std::string& body) {
  return "POST " + address.path + name + " HTTP/1.1\r\nHost: " + address.host +
         "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
}

}  // namespace cdb::tests
