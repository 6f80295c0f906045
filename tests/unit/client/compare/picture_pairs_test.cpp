#include <client/compare/compared_pictures.h>
#include <equistream/error.h>
#include <equistream/sequence.h>

#include <gtest/gtest.h>

#include <fstream>

#include <unistd.h>

namespace equistream {
namespace {

namespace fs = std::filesystem;

class PicturePairs : public ::testing::Test {
protected:
    void SetUp() override {
        root_ = fs::temp_directory_path() / ("equistream_pairs_" + std::to_string(getpid()));
        fs::remove_all(root_);
    }
    void TearDown() override { fs::remove_all(root_); }

    void make_frames(const std::string& folder, int count, const std::string& extension = "png") {
        fs::create_directories(root_ / folder);
        for (int i = 0; i < count; ++i)
            std::ofstream(root_ / folder / frame_file_name(i, extension)).put('\n');
    }
    PairingOptions options(const std::string& a, const std::string& truth) {
        PairingOptions pairing;
        pairing.picture = root_ / a;
        pairing.truth = root_ / truth;
        return pairing;
    }
    static std::string error_of(const PairingOptions& pairing) {
        try {
            pair_pictures(pairing);
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    }

    fs::path root_;
};

TEST_F(PicturePairs, LeftAndRightArePairedApart) {
    make_frames("a/left", 3), make_frames("a/right", 3);
    make_frames("t/left", 3, "exr"), make_frames("t/right", 3, "exr");
    const auto eyes = pair_pictures(options("a", "t"));
    ASSERT_EQ(eyes.size(), 2u);
    EXPECT_EQ(eyes[0].eye, "left");
    EXPECT_EQ(eyes[1].eye, "right");
    ASSERT_EQ(eyes[1].pairs.size(), 3u);
    EXPECT_EQ(eyes[1].pairs[2].picture, root_ / "a/right/frame.0002.png");
    EXPECT_EQ(eyes[1].pairs[2].truth, root_ / "t/right/frame.0002.exr");
    EXPECT_EQ(eyes[1].pairs[2].frame, 2);
}

TEST_F(PicturePairs, BareFoldersAndFilesAreOneView) {
    make_frames("a", 2), make_frames("t", 2);
    EXPECT_EQ(pair_pictures(options("a", "t")).at(0).eye, "view");
    const auto files = pair_pictures(options("a/frame.0000.png", "t/frame.0001.png"));
    ASSERT_EQ(files.at(0).pairs.size(), 1u);
    EXPECT_FALSE(files[0].pairs[0].frame.has_value());
    EXPECT_NE(error_of(options("a/frame.0000.png", "t")).find("a mixture"), std::string::npos);
}

TEST_F(PicturePairs, SecondRunAndGapsFollowTheFrames) {
    for (const char* folder : {"a/left", "t/left", "a2/left", "t2/left", "g/left"})
        make_frames(folder, 2);
    PairingOptions pairing = options("a", "t");
    pairing.second_picture = root_ / "a2";
    pairing.second_truth = root_ / "t2";
    pairing.gaps = root_ / "g";
    const PicturePair pair = pair_pictures(pairing).at(0).pairs.at(1);
    EXPECT_EQ(pair.second_picture, root_ / "a2/left/frame.0001.png");
    EXPECT_EQ(pair.second_truth, root_ / "t2/left/frame.0001.png");
    EXPECT_EQ(pair.gaps, root_ / "g/left/frame.0001.png");
}

TEST_F(PicturePairs, FrameRangeSelects) {
    make_frames("a", 5), make_frames("t", 4);
    PairingOptions pairing = options("a", "t");
    EXPECT_NE(error_of(pairing).find("t/frame.0004.png: expected a frame to compare"), std::string::npos);
    pairing.first_frame = 1;
    pairing.last_frame = 3;
    EXPECT_EQ(pair_pictures(pairing).at(0).pairs.size(), 3u);
    pairing.last_frame = 4;
    EXPECT_NE(error_of(pairing), "");
}

TEST_F(PicturePairs, WhatIsMissingIsNamed) {
    make_frames("a/left", 1), make_frames("a/right", 1), make_frames("t/left", 1);
    EXPECT_NE(error_of(options("a", "t")).find("t/right: expected"), std::string::npos);
    EXPECT_NE(error_of(options("nowhere", "t/left")).find("nowhere: expected"), std::string::npos);
    fs::create_directories(root_ / "empty");
    EXPECT_NE(error_of(options("empty", "empty")).find("found no frame"), std::string::npos);
    make_frames("both", 1, "png"), make_frames("both", 1, "exr");
    EXPECT_NE(error_of(options("both", "both")).find("frames of one format"), std::string::npos);
    PairingOptions pairing = options("a", "t");
    pairing.eyes = {"middle"};
    EXPECT_NE(error_of(pairing).find("left, right, centre or small"), std::string::npos);
    pairing.eyes = {"left"};
    EXPECT_EQ(pair_pictures(pairing).size(), 1u);
}

TEST_F(PicturePairs, SingleFilesHaveNoFramesToChooseFrom) {
    make_frames("a", 2), make_frames("t", 2);
    PairingOptions pairing = options("a/frame.0000.png", "t/frame.0001.png");
    pairing.first_frame = pairing.last_frame = 1;
    EXPECT_EQ(error_of(pairing), "--frames: expected folders of frames to choose from, found the single file " +
                                     (root_ / "a/frame.0000.png").string());
}

TEST_F(PicturePairs, MoreFramesInTheTruthNeedARange) {
    make_frames("a", 2), make_frames("t", 3);
    EXPECT_NE(error_of(options("a", "t")).find("found 3 frames"), std::string::npos);
}

}  // namespace
}  // namespace equistream
