#pragma once
/// A rendered sequence coded by `equistream encode` as a child process.
#include <asio/signal_set.hpp>

#include <string>
#include <vector>

namespace equistream::serve {

/// Waits for `equistream encode` with these arguments, whose report goes to standard error. True: done. False: one of
/// the signals of `stop` came, and the child has been ended. Throws cli::ChildFailed where the child fails. `io` is
/// the context of `stop` and has nothing else to do.
bool run_encode(asio::io_context& io, asio::signal_set& stop, const std::vector<std::string>& arguments);

}  // namespace equistream::serve
