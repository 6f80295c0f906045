/// What viewers of a recorded stream are sent who keep up, and who do not.
#include <programs/serve/programmes.h>
#include <tests/unit/plugin/stream/synthetic.h>

#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <iterator>
#include <string>

namespace equistream::serve {
namespace {

/// The pictures of tiles and of main that a viewer gets who asks for bytes so much later than they are due.
struct Counts {
    int tiles = 0, main = 0;
};

Counts sent_to_one_behind_by(Programme& programme, double behind_s, const std::filesystem::path& file) {
    const auto feed = programme.open_feed();
    std::ofstream sent(file, std::ios::binary);
    std::array<char, 1 << 16> block;
    double elapsed_s = behind_s;
    for (;;) {
        const Portion portion = feed->next(block, elapsed_s);
        EXPECT_EQ(portion.problem, "");
        if (portion.ended || !portion.problem.empty())
            break;
        sent.write(block.data(), std::streamsize(portion.bytes));
        if (portion.again_s)
            elapsed_s = *portion.again_s + behind_s;
    }
    sent.close();
    StreamReader reader(file.string());
    Counts counts;
    while (const auto picture = reader.next())
        ++(picture->role == TrackRole::window ? counts.tiles : counts.main);
    return counts;
}

/// Clients give up a server that says nothing for 10 s.
TEST(Recordings, SaySomethingEverySecond) {
    const synthetic::Folder folder;
    const synthetic::Made made = synthetic::small_stream(Codec::h264, false);
    StreamSettings settings = made.settings;
    settings.frames_per_second = 0.05;
    const std::filesystem::path file = folder / "slow.mkv", sent_file = folder / "sent.mkv";
    {
        StreamWriter writer(file.string(), settings);
        for (std::int64_t index = 0; index < made.pictures; ++index) {
            FrameInfo info = synthetic::info(192, 96, index);
            info.frames_per_second = 0.05;
            info.time_s = 20 * double(index);
            writer.write(TrackRole::main, synthetic::picture(192, 96, index).view(), info);
        }
        writer.finish();
    }
    const auto programme = open_recording(file.string(), false);
    const auto feed = programme->open_feed();
    std::ofstream sent(sent_file, std::ios::binary);
    std::array<char, 1 << 16> block;
    double elapsed_s = 0, last_sent_s = 0;
    for (;;) {
        const Portion portion = feed->next(block, elapsed_s);
        ASSERT_EQ(portion.problem, "");
        if (portion.ended)
            break;
        sent.write(block.data(), std::streamsize(portion.bytes));
        if (portion.bytes > 0) {
            EXPECT_LE(elapsed_s, last_sent_s + 1.001);
            last_sent_s = elapsed_s;
        }
        if (portion.again_s)
            elapsed_s = *portion.again_s;
    }
    EXPECT_GE(elapsed_s, 20 * (made.pictures - 1)) << "no picture comes before its time";
    sent.close();
    std::ifstream whole(file, std::ios::binary), again(sent_file, std::ios::binary);
    const std::string expected(std::istreambuf_iterator<char>(whole), {}),
        found(std::istreambuf_iterator<char>(again), {});
    EXPECT_TRUE(found == expected);
}

TEST(TiledRecordings, GiveAViewerBehindTheBaseAlone) {
    const synthetic::Folder folder;
    const synthetic::MadeTiles made{.grid = {8, 4}, .pictures = 24, .gop = 10};
    synthetic::write(folder / "tiles.mkv", made);
    const auto programme = open_recording((folder / "tiles.mkv").string(), false);
    const Counts level = sent_to_one_behind_by(*programme, 0, folder / "level.mkv");
    const Counts behind = sent_to_one_behind_by(*programme, 100, folder / "behind.mkv");
    EXPECT_EQ(level.main, 24);
    EXPECT_EQ(behind.main, 24) << "the base is never left out";
    EXPECT_GT(level.tiles, 24);
    EXPECT_EQ(behind.tiles, 32) << "the first moment's, by which readers know each track";
}

}  // namespace
}  // namespace equistream::serve
