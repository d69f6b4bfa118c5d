// The HTTP server of the editor, on the loopback interface.
//
// Each start has a random port and a random token of 128 bits, which is part of every path, so that
// neither other users of the machine nor pages of other sites can reach it. It answers one request
// at a time.
#pragma once

#include <functional>
#include <string>

#include "runtime/pages/serve/editor.h"

namespace cdb::serve {

/// Serves until `stop_fd` becomes readable. `begin` is called with the address. Throws
/// std::system_error if no port is available; std::runtime_error if this build has no server.
void Serve(Editor& editor, int stop_fd, const std::function<void(const std::string&)>& begin);

}  // namespace cdb::serve
