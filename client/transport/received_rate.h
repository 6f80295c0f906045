#pragma once
/// How fast a server reads.

namespace equistream {

/// What viewers send, whatever it is; more waits in their own systems.
inline constexpr double received_bytes_per_second = 65536;

}  // namespace equistream
