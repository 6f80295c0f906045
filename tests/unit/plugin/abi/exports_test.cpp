// The library exports its C ABI and nothing else, whatever static libraries came along.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <memory>
#include <set>
#include <string>

namespace {

TEST(Exports, are_the_functions_of_the_header_only) {
    const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen("nm -D --defined-only " EQUISTREAM_LIBRARY, "r"), pclose);
    ASSERT_TRUE(pipe);
    std::set<std::string> found;
    std::array<char, 512> line{};
    while (std::fgets(line.data(), line.size(), pipe.get()) != nullptr) {
        const std::string text(line.data());
        const std::string name = text.substr(text.find_last_of(' ') + 1);
        found.insert(name.substr(0, name.find('\n')));
    }
    const std::set<std::string> wanted = {"es_abi_version",       "es_version",
                                          "es_sequence_open",     "es_sequence_has_frame",
                                          "es_sequence_close",    "es_frame_begin",
                                          "es_frame_next_tile",   "es_tile_geometry_rays",
                                          "es_tile_probe_rays",   "es_tile_put_distances",
                                          "es_tile_colour_rays",  "es_tile_put_surfaces",
                                          "es_tile_put_radiance", "es_tile_put_guides",
                                          "es_tile_put_ids",      "es_frame_put_plane",
                                          "es_frame_end",         "es_frame_discard"};
    EXPECT_EQ(found, wanted);
}

}  // namespace
