#include "congestion.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string_view>

namespace equistream {

bool use_bbr(int socket) {
    constexpr std::string_view name = "bbr";
    return setsockopt(socket, IPPROTO_TCP, TCP_CONGESTION, name.data(), socklen_t(name.size())) == 0;
}

void keep_little_unsent(int socket) {
    constexpr int bytes = 1 << 14;
    setsockopt(socket, IPPROTO_TCP, TCP_NOTSENT_LOWAT, &bytes, sizeof bytes);
}

bool allows_bbr() {
    const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (socket < 0)
        return false;
    const bool allows = use_bbr(socket);
    ::close(socket);
    return allows;
}

}  // namespace equistream
