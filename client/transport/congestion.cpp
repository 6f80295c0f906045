#include "congestion.h"

#include <linux/sockios.h>
#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <string_view>

namespace equistream {

namespace {

/// TCP_CLOSE of <netinet/tcp.h>, which cannot stand beside <linux/tcp.h>.
constexpr int tcp_closed = 7;

}  // namespace

bool use_bbr(int socket) {
    constexpr std::string_view name = "bbr";
    return setsockopt(socket, IPPROTO_TCP, TCP_CONGESTION, name.data(), socklen_t(name.size())) == 0;
}

void keep_little_unsent(int socket) {
    constexpr int bytes = 1 << 14;
    setsockopt(socket, IPPROTO_TCP, TCP_NOTSENT_LOWAT, &bytes, sizeof bytes);
}

Unacknowledged unacknowledged(int socket) {
    int bytes = 0;
    if (ioctl(socket, SIOCOUTQ, &bytes) != 0)
        return {};
    tcp_info info{};
    socklen_t size = sizeof info;
    const bool says = getsockopt(socket, IPPROTO_TCP, TCP_INFO, &info, &size) == 0 &&
                      size >= offsetof(tcp_info, tcpi_min_rtt) + sizeof info.tcpi_min_rtt;
    if (says && info.tcpi_state == tcp_closed)
        return {};
    // Before the first measurement the system says the highest number.
    const bool is_known = says && info.tcpi_min_rtt != ~__u32{0};
    return {std::size_t(std::max(0, bytes)), is_known ? 1e-6 * info.tcpi_min_rtt : 0};
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
