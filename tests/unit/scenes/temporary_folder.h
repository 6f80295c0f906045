#pragma once
/// A folder that lives as long as a test.
#include <equistream/error.h>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace equistream::test {

class TemporaryFolder : public ::testing::Test {
protected:
    TemporaryFolder() {
        std::string name = (std::filesystem::temp_directory_path() / "equistream-test-XXXXXX").string();
        if (!mkdtemp(name.data()))
            throw WorkError("cannot make a temporary folder");
        folder_ = name;
    }
    ~TemporaryFolder() override { std::filesystem::remove_all(folder_); }

    std::filesystem::path write(const std::string& name, const std::string& content) const {
        const std::filesystem::path file = folder_ / name;
        std::filesystem::create_directories(file.parent_path());
        std::ofstream(file, std::ios::binary) << content;
        return file;
    }

    std::filesystem::path folder_;
};

/// Runs `work` and returns the message of the InputError it must throw.
template <typename Work>
std::string input_error(Work&& work) {
    try {
        work();
    } catch (const InputError& error) {
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
        return error.what();
    }
    ADD_FAILURE() << "no InputError was thrown";
    return {};
}

inline void expect_contains(const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << "\"" << part << "\" is not in \"" << text << "\"";
}

// An RGBA PNG in memory, by OpenImageIO's writer.

inline std::string png_rgba(int width, int height, const std::vector<std::uint8_t>& rgba) {
    OIIO::Filesystem::IOVecOutput memory;
    const auto output = OIIO::ImageOutput::create("png");
    const OIIO::ImageSpec spec(width, height, 4, OIIO::TypeDesc::UINT8);
    output->set_ioproxy(&memory);
    output->open("memory.png", spec);
    output->write_image(OIIO::TypeDesc::UINT8, rgba.data());
    output->close();
    const auto& bytes = memory.buffer();
    return {bytes.begin(), bytes.end()};
}

}  // namespace equistream::test
