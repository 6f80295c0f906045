#pragma once
/// How fast TCP sends.

namespace equistream {

/// By the rate at which data arrive, not by what is lost (Cardwell et al. 2016, "BBR: congestion-based congestion
/// control"). Where the system does not allow it, its own stays. Whether it does.
bool use_bbr(int socket);
/// Whether this system lets anybody use it.
bool allows_bbr();

}  // namespace equistream
