// The client's library and its modules export what they promise and nothing else, whatever static libraries came along;
// and the library by itself needs neither Embree nor OpenGL.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <memory>
#include <set>
#include <string>

namespace {

std::string output_of(const std::string& command) {
    const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
    std::string all;
    std::array<char, 512> line{};
    while (pipe && std::fgets(line.data(), line.size(), pipe.get()) != nullptr)
        all += line.data();
    return all;
}

std::set<std::string> exports_of(const std::string& library) {
    std::set<std::string> found;
    const std::string all = output_of("nm -D --defined-only --format=posix " + library);
    for (std::size_t begin = 0; begin < all.size(); begin = all.find('\n', begin) + 1)
        found.insert(all.substr(begin, all.find(' ', begin) - begin));
    return found;
}

TEST(ClientExports, AreTheFunctionsOfTheHeaderOnly) {
    const std::set<std::string> wanted = {"es_client_abi_version", "es_client_version",        "es_client_open",
                                          "es_client_close",       "es_client_get_source",     "es_client_now_s",
                                          "es_client_render",      "es_client_draw",           "es_client_get_textures",
                                          "es_client_send_head",   "es_client_pause",          "es_client_play",
                                          "es_client_seek",        "es_client_get_statistics", "es_client_set_eyes"};
    EXPECT_EQ(exports_of(EQUISTREAM_LIBRARY), wanted);
}

TEST(ClientExports, OfModulesAreTheirTables) {
    EXPECT_EQ(exports_of(EQUISTREAM_EMBREE_MODULE), (std::set<std::string>{"equistream_client_module_embree"}));
    EXPECT_EQ(exports_of(EQUISTREAM_GL_MODULE), (std::set<std::string>{"equistream_client_module_gl"}));
}

TEST(ClientExports, TheLibraryNeedsNeitherEmbreeNorOpenGl) {
    const std::string needed = output_of("readelf -d " EQUISTREAM_LIBRARY);
    ASSERT_NE(needed.find("libavcodec"), std::string::npos) << needed;
    for (const char* other : {"embree", "libGL", "libEGL", "epoxy", "OpenImageIO"})
        EXPECT_EQ(needed.find(other), std::string::npos) << needed;
}

}  // namespace
