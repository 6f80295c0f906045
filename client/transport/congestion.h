#pragma once
/// How fast TCP sends.
#include "under_way.h"

namespace equistream {

/// By the rate at which data arrive, not by what is lost (Cardwell et al. 2016, "BBR: congestion-based congestion
/// control"). Where the system does not allow it, its own stays. Whether it does.
bool use_bbr(int socket);
/// Little waits in the system that it has not begun to send: more would be old by the time it goes.
void keep_little_unsent(int socket);
/// How much of what was written to a socket has not been acknowledged. Of one that is not TCP the bytes may be more,
/// and no time is known. Where the other end has broken off, nothing is under way: the next write says so.
Unacknowledged unacknowledged(int socket);
/// Whether whoever runs this may use BBR.
bool allows_bbr();

}  // namespace equistream
