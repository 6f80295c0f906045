/// Both eyes as one ordinary video.
#include <tests/unit/programs/programs_fixture.h>

#include <nlohmann/json.hpp>

namespace equistream::test {
namespace {

namespace fs = std::filesystem;

ByteImage half(const ByteImage& both, bool second, bool beside) {
    const int width = beside ? both.width() / 2 : both.width(), height = beside ? both.height() : both.height() / 2;
    ByteImage one(width, height, 3);
    for (int y = 0; y < height; ++y)
        std::copy_n(both.pixel(second && beside ? width : 0, second && !beside ? y + height : y), 3 * width,
                    one.pixel(0, y));
    return one;
}

/// The left eye's pictures of frame i are picture(i); the right one's another's.
TEST_F(Programs, BothEyesGoIntoOneOrdinaryVideo) {
    render("r/left", 192, 96, 3, 6, Eye::left);
    render("r/right", 192, 96, 3, 6, Eye::right);
    for (const bool beside : {false, true}) {
        const std::string how = beside ? "side-by-side" : "top-bottom";
        for (const std::string type : {".mp4", ".mkv"}) {
            const Ran ran = run("encode '" + path("r") + "' --stereo " + how +
                                " --preset veryfast --crf 12 --json --out '" + path(how + type) + "'");
            ASSERT_EQ(ran.status, 0) << ran.errors;
            const auto report = nlohmann::json::parse(ran.output);
            EXPECT_EQ(report["stereo"], how);
            ASSERT_EQ(report["tracks"].size(), 1u);
            EXPECT_EQ(report["tracks"][0]["width"], beside ? 384 : 192);
            EXPECT_EQ(report["tracks"][0]["height"], beside ? 96 : 192);
            EXPECT_TRUE(report["sphere_tag"]);
            StreamReader reader(path(how + type));
            EXPECT_EQ(reader.tracks().front().stereo, beside ? StereoPacking::side_by_side : StereoPacking::top_bottom);
            EXPECT_TRUE(reader.tracks().front().equirect);
            const auto pictures = synthetic::read_all(reader);
            ASSERT_EQ(pictures.size(), 4u);
            for (std::size_t i = 0; i < pictures.size(); ++i) {
                EXPECT_FALSE(pictures[i].info) << "no one camera took it";
                const ByteImage expected = synthetic::picture(192, 96, std::int64_t(i) + 3);
                EXPECT_GT(synthetic::psnr_db(half(pictures[i].rgb, false, beside), expected), 36);
                EXPECT_GT(synthetic::psnr_db(half(pictures[i].rgb, true, beside), expected), 36);
            }
        }
    }
}

TEST_F(Programs, TheLeftEyeIsAboveTheRightOne) {
    render("r/left", 64, 64, 0, 0, Eye::left);
    render("other", 64, 64, 7, 7, Eye::right);
    fs::create_directories(folder / "r/right");
    // Frame 7's colours as frame 0 of the right eye.
    Frame frame = read_exr(folder / "other" / frame_file_name(7));
    frame.info = info(64, 64, 0, Eye::right);
    write_exr(folder / "r/right" / frame_file_name(0), frame);
    ASSERT_EQ(run("encode '" + path("r") + "' --stereo top-bottom --crf 4 --out '" + path("a.mkv") + "'").status, 0);
    StreamReader reader(path("a.mkv"));
    const auto picture = reader.next();
    ASSERT_TRUE(picture);
    EXPECT_GT(synthetic::psnr_db(half(picture->rgb, false, false), synthetic::picture(64, 64, 0)), 36);
    EXPECT_GT(synthetic::psnr_db(half(picture->rgb, true, false), synthetic::picture(64, 64, 7)), 36);
    EXPECT_LT(synthetic::psnr_db(half(picture->rgb, true, false), synthetic::picture(64, 64, 0)), 30);
}

TEST_F(Programs, TheEyeThatIsLeftOutIsNamed) {
    render("r/left", 64, 64, 0, 1, Eye::left);
    render("r/right", 64, 64, 0, 1, Eye::right);
    const std::string encode = "encode '" + path("r") + "' --preset ultrafast --out '" + path("a.mkv") + "' ";
    const Ran text = run(encode);
    ASSERT_EQ(text.status, 0) << text.errors;
    EXPECT_NE(text.output.find("right/ is left out: clients make both eyes of " + path("r/left") +
                               " by depth (--eye right sends that instead, --stereo top-bottom both"),
              std::string::npos)
        << text.output;
    const auto left_out = [&](const std::string& more) {
        return nlohmann::json::parse(run(encode + "--json " + more).output)["left_out"];
    };
    EXPECT_EQ(left_out(""), nlohmann::json({"right"}));
    EXPECT_EQ(left_out("--eye right"), nlohmann::json({"left"}));
    EXPECT_EQ(left_out("--stereo top-bottom"), nlohmann::json::array());
    EXPECT_EQ(nlohmann::json::parse(
                  run("encode '" + path("r/left") + "' --preset ultrafast --json --out '" + path("a.mkv") + "'")
                      .output)["left_out"],
              nlohmann::json::array());
}

TEST_F(Programs, BothEyesMustBeThereAndBelongTogether) {
    render("r/left", 64, 64, 0, 1, Eye::left);
    const std::string words = "encode '" + path("r") + "' --out '" + path("a.mkv") + "' --stereo top-bottom";
    expect_failure(run(words), 2, "r/right: expected frame.NNNN.exr files of that eye (render --eye both), found none");
    render("r/right", 64, 64, 0, 0, Eye::right);
    expect_failure(run(words), 2, "r/right: expected frames 0-1");
    render("r/right", 64, 66, 0, 1, Eye::right);
    expect_failure(run(words), 2, "expected the left eye's size, 64x64, found 64x66");
    render("r/right", 64, 64, 0, 1, Eye::right, 5);
    expect_failure(run(words), 2, "expected the seed of " + path("r/left"));
    render("r/right", 64, 64, 0, 1, Eye::right);
    EXPECT_EQ(run(words).status, 0);
    for (const std::string more : {"--depth auto", "--eye left", "--fill small", "--mirrors always"})
        expect_failure(run(words + " " + more), 2, "nothing beside it, found " + more);
}

}  // namespace
}  // namespace equistream::test
