/// True eyes are read by a thread of their own: who asks for one never waits.
#include "frames_folder.h"

#include <client/view/truth.h>

#include <equistream/error.h>

#include <gtest/gtest.h>

#include <sys/stat.h>

#include <fcntl.h>
#include <fstream>
#include <string>

namespace equistream::test {
namespace {

class TrueEyes : public testing::Test {
protected:
    static constexpr double interval_s = 1.0 / 30;

    std::filesystem::path folder =
        std::filesystem::temp_directory_path() / ("equistream_truth_" + std::to_string(::getpid()));

    std::filesystem::path file(const char* eye, int index) const { return folder / eye / frame_file_name(index); }
    /// Whose brightness is the frame's number, and the right eye's half as much.
    void SetUp() override {
        for (const char* eye : {"left", "right"}) {
            std::filesystem::create_directories(folder / eye);
            for (int index = 0; index < 6; ++index) {
                Frame frame;
                frame.info.index = index;
                frame.info.time_s = index * interval_s;
                frame.info.camera = PerspectiveCamera{32, 16, 1};
                frame.info.head.position_m.x = index;
                frame.planes["colour"] = FloatImage(32, 16, 4, 0.1f * float(index) / (eye[0] == 'l' ? 1 : 2));
                write_exr(file(eye, index), frame);
            }
        }
    }
    void TearDown() override { std::filesystem::remove_all(folder); }

    static Truth::Found waited_for(Truth& truth, double time_s, Eye eye) {
        for (int i = 0; i < 20000; ++i, doze())
            if (Truth::Found found = truth.at(time_s, eye); !found.is_coming)
                return found;
        ADD_FAILURE() << "nothing was read within 20 s";
        return {};
    }
};

TEST_F(TrueEyes, AreThoseOfTheTimeAndTheEyeThatAreAskedFor) {
    Truth truth(folder);
    EXPECT_EQ(truth.camera().width, 32);
    for (const int index : {0, 1, 2, 5, 3}) {
        const Truth::Found left = waited_for(truth, (index + 0.3) * interval_s, Eye::left);
        ASSERT_TRUE(left.eye) << left.problem;
        EXPECT_EQ(left.eye->head.position_m.x, index);
        const Truth::Found right = waited_for(truth, index * interval_s, Eye::right);
        ASSERT_TRUE(right.eye) << right.problem;
        EXPECT_EQ(right.eye->rgb.samples()[0]<left.eye->rgb.samples()[0], index> 0);
    }
    const Truth::Found none = waited_for(truth, 6 * interval_s, Eye::left);
    EXPECT_EQ(none.eye, nullptr);
    EXPECT_EQ(none.problem, "");
}

TEST_F(TrueEyes, AreNotWaitedFor) {
    // Who reads it waits until somebody writes into it.
    std::filesystem::remove(file("left", 1));
    ASSERT_EQ(mkfifo(file("left", 1).c_str(), 0600), 0);
    Truth truth(folder);
    EXPECT_TRUE(truth.at(interval_s, Eye::left).is_coming);
    const int written = open(file("left", 1).c_str(), O_WRONLY);  // the thread is at it
    close(written);
    EXPECT_NE(waited_for(truth, interval_s, Eye::left).problem, "");
    EXPECT_TRUE(waited_for(truth, 2 * interval_s, Eye::left).eye);
}

TEST_F(TrueEyes, SayWhatCannotBeReadAndGoOn) {
    std::ofstream(file("left", 1)) << "no picture";
    Truth truth(folder);
    EXPECT_TRUE(waited_for(truth, 0, Eye::left).eye);
    const Truth::Found broken = waited_for(truth, interval_s, Eye::left);
    EXPECT_EQ(broken.eye, nullptr);
    EXPECT_NE(broken.problem.find("frame.0001.exr"), std::string::npos) << broken.problem;
    EXPECT_TRUE(waited_for(truth, interval_s, Eye::right).eye);
    EXPECT_TRUE(waited_for(truth, 2 * interval_s, Eye::left).eye);
    std::ofstream(file("left", 0)) << "no picture";
    EXPECT_THROW(Truth again(folder), InputError);
}

}  // namespace
}  // namespace equistream::test
