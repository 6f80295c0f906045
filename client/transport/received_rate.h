#pragma once

namespace equistream {

/// How fast a server reads what viewers send; the rest waits in their systems.
inline constexpr double received_bytes_per_second = 65536;

}  // namespace equistream
