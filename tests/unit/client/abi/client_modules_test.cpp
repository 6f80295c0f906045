/// A module of other code than the library's, as a reinstall that was broken off leaves it, is refused and not called.
#include <client/include/equistream/client.h>

#include <gtest/gtest.h>

#include <dlfcn.h>
#include <unistd.h>

#include <filesystem>
#include <string>

namespace {

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
        EXPECT_TRUE(text.starts_with(module_file(module) + ": expected a module of the library's own code, ")) << text;
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
