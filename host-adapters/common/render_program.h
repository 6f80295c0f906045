#pragma once
/// The whole of `equistream render` around one host.
#include "host.h"

namespace equistream::render_command {

/// Parses, loads, renders every frame that is not there yet, reports; returns the exit status. An interrupt (SIGINT,
/// SIGTERM) leaves whole frames only and ends in an error that says how many.
int run(int argc, char** argv, RenderHost& host);

}  // namespace equistream::render_command

// Which code this program was built from.

namespace equistream {

/// Eight hexadecimal digits over the sources that decide pixels, as each host lists them
/// (cmake/CodeIdentity.cmake).
const char* code_identity();

}  // namespace equistream
