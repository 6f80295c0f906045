#pragma once
/// The hosts table: what `--host` of render and serve may name. A new host is one row.
#include <array>
#include <string>
#include <string_view>

namespace equistream::cli {

struct Host {
    std::string_view name;
    std::string_view program;        ///< beside the dispatcher
    std::string_view how_to_get_it;  ///< said where this build does not have it
};

/// The first is the default.
inline constexpr std::array hosts = {
    Host{"embree", "equistream-render-embree", "configure with it and build"},
    Host{"mitsuba", "equistream-render-mitsuba",
         "pip install mitsuba==3.9.1 nanobind==2.14.0, configure again and build (docs/mitsuba.md)"},
};

/// Null: there is none of that name.
inline const Host* find_host(std::string_view name) {
    for (const Host& host : hosts)
        if (host.name == name)
            return &host;
    return nullptr;
}

/// "embree or mitsuba".
inline std::string host_names() {
    std::string names;
    for (const Host& host : hosts)
        names += (names.empty() ? "" : &host == &hosts.back() ? " or " : ", ") + std::string(host.name);
    return names;
}

}  // namespace equistream::cli
