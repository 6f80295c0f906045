#pragma once
/// equistream-encode and equistream-info as a user runs them.
#include <tests/unit/plugin/stream/synthetic.h>

#include <equistream/colour.h>
#include <equistream/sequence.h>

#include <gtest/gtest.h>

#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace equistream::test {

struct Ran {
    int status;
    std::string output;
    std::string errors;
};

inline std::string text_of(const std::filesystem::path& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
}

class Programs : public testing::Test {
protected:
    synthetic::Folder folder;

    Ran run(const std::string& arguments, const std::string& input = "/dev/null") const {
        return run_line(EQUISTREAM_BIN "/equistream-" + arguments, input);
    }
    /// A line of the shell.
    Ran run_line(const std::string& line, const std::string& input = "/dev/null") const {
        const std::string command =
            line + " >'" + (folder / "out").string() + "' 2>'" + (folder / "err").string() + "' <'" + input + "'";
        const int status = std::system(command.c_str());
        return {WEXITSTATUS(status), text_of(folder / "out"), text_of(folder / "err")};
    }
    std::string path(const std::string& name) const { return (folder / name).string(); }

    static FrameInfo info(int width, int height, std::int64_t index, Eye eye) {
        FrameInfo info = synthetic::info(width, height, index, eye);
        info.seed = 1000;  // a render has one
        return info;
    }

    /// Frames whose display-referred picture is synthetic::picture of their index and `ahead`.
    void render(const std::string& name, int width, int height, std::int64_t first, std::int64_t last,
                Eye eye = Eye::centre, std::uint64_t seed = 1000, std::int64_t ahead = 0) const {
        std::filesystem::create_directories(folder / name);
        const DisplayTransform display;
        for (std::int64_t index = first; index <= last; ++index) {
            Frame frame;
            frame.info = info(width, height, index, eye);
            frame.info.seed = seed;
            const FloatImage linear = display.to_linear(
                widen_8bit(synthetic::picture(width, height, index + ahead).view()).view(), frame.info.exposure);
            FloatImage colour(width, height, 4, 1.0f);
            for (int y = 0; y < height; ++y)
                for (int x = 0; x < width; ++x)
                    std::copy_n(linear.pixel(x, y), 3, colour.pixel(x, y));
            frame.planes.emplace("colour", std::move(colour));
            write_exr(folder / name / frame_file_name(index), frame);
        }
    }

    void expect_failure(const Ran& ran, int status, const std::string& part) const {
        EXPECT_EQ(ran.status, status) << ran.errors;
        EXPECT_NE(ran.errors.find(part), std::string::npos) << ran.errors;
        EXPECT_EQ(std::count(ran.errors.begin(), ran.errors.end(), '\n'), 1) << ran.errors;
    }
};

}  // namespace equistream::test
