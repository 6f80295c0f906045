// The client's library and its modules export what they promise and nothing else, whatever static libraries came along;
// and the library by itself needs neither Embree nor OpenGL. A module of other code than the library's, as a reinstall
// that was broken off leaves it, is refused and not called.
#include <client/include/equistream/client.h>

#include <gtest/gtest.h>

#include <dlfcn.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <filesystem>
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

namespace fs = std::filesystem;

/// The library, alone with old modules.
class ClientModules : public testing::Test {
protected:
    void SetUp() override {
        fs::create_directories(folder_ / "equistream");
        fs::copy_file(EQUISTREAM_LIBRARY, folder_ / "libequistream_client.so");
        for (const char* name : {"embree", "gl"})
            fs::copy_file(EQUISTREAM_STALE_MODULE, module_file(name));
        void* const library = dlopen((folder_ / "libequistream_client.so").c_str(), RTLD_NOW | RTLD_LOCAL);
        ASSERT_NE(library, nullptr) << dlerror();
        open_ = reinterpret_cast<decltype(&es_client_open)>(dlsym(library, "es_client_open"));
        ASSERT_NE(open_, nullptr);
    }
    void TearDown() override { fs::remove_all(folder_); }

    std::string module_file(const std::string& name) const {
        return fs::canonical(folder_) / "equistream" / ("libequistream_client_" + name + ".so");
    }
    void expect_refused(const std::string& module, es_backend backend) const {
        es_client_settings settings{};
        settings.struct_size = sizeof settings;
        settings.abi_version = ES_CLIENT_ABI_VERSION;
        settings.backend = backend;
        settings.source = "walk.mp4";
        settings.scene = "walk.json";
        es_client* client = nullptr;
        es_error error{};
        EXPECT_EQ(open_(&settings, &client, &error), ES_BAD_INPUT);
        const std::string text = error.text;
        EXPECT_TRUE(text.starts_with(module_file(module) + ": expected a module from the same build as this library, "))
            << text;
        EXPECT_TRUE(text.ends_with(", found 0.1.0")) << text;
    }

private:
    const fs::path folder_ = fs::temp_directory_path() / ("equistream_modules_" + std::to_string(::getpid()));
    decltype(&es_client_open) open_ = nullptr;
};

TEST_F(ClientModules, OfOtherCodeAreRefused) {
    expect_refused("embree", ES_BACKEND_CPU);
    expect_refused("gl", ES_BACKEND_OPENGL);
}

}  // namespace
