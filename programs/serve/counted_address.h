#pragma once
/// What limits by address count. `Address` is an address of Asio's or of Boost.Asio's.
#include <algorithm>

namespace equistream::serve {

/// Where both kinds of addresses are listened to, IPv4's come within IPv6's.
template <typename Address>
Address unmapped(const Address& address) {
    using V4 = decltype(address.to_v4());
    if (!address.is_v6() || !address.to_v6().is_v4_mapped())
        return address;
    const auto bytes = address.to_v6().to_bytes();
    return V4(typename V4::bytes_type{{bytes[12], bytes[13], bytes[14], bytes[15]}});
}

/// IPv4's address, also where it comes within IPv6's; of IPv6 the network of 64 bits, all of whose addresses one
/// machine may have.
template <typename Address>
Address counted_address(const Address& peer) {
    const Address address = unmapped(peer);
    if (!address.is_v6() || address.is_loopback())
        return address;
    auto bytes = address.to_v6().to_bytes();
    std::fill(bytes.begin() + 8, bytes.end(), static_cast<unsigned char>(0));
    return decltype(address.to_v6())(bytes);
}

}  // namespace equistream::serve
