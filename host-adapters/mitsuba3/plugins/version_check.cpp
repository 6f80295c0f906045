#include "version_check.h"

#include <equistream/error.h>

namespace equistream::mitsuba_host {

std::string release_in(const std::string& info_build) {
    const std::string before = "Mitsuba version ";
    const std::size_t at = info_build.find(before);
    if (at == std::string::npos)
        return {};
    const std::size_t begin = at + before.size();
    return info_build.substr(begin, info_build.find_first_of(" \n(", begin) - begin);
}

void require_release(const std::string& plugin, const std::string& info_build, const std::string& expected) {
    const std::string found = release_in(info_build);
    if (found != expected)
        throw std::runtime_error(expected_found("equistream's plugin \"" + plugin + "\"",
                                                "Mitsuba " + expected + ", for which it was compiled",
                                                found.empty() ? "\"" + info_build + "\"" : "Mitsuba " + found));
}

}  // namespace equistream::mitsuba_host
