/// Of a recording's tiles, those that a viewer looks at.
#include "synthetic.h"

#include <equistream/error.h>
#include <equistream/tile_stream.h>

#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <map>
#include <random>
#include <set>
#include <tuple>

namespace equistream {
namespace {

/// Containers' own clocks count whole milliseconds or finer.
constexpr double clock_s = 1e-3;

/// Pictures are coded at most so many before others that are shown earlier: three between references, and these.
constexpr int max_reordered = 4;

/// By track and index.
using Pictures = std::map<std::pair<std::size_t, std::int64_t>, ByteImage>;

Pictures pictures_of(const std::filesystem::path& file) {
    StreamReader reader(file.string());
    Pictures pictures;
    for (DecodedPicture& picture : synthetic::read_all(reader))
        pictures[{picture.track, picture.info.value().index}] = std::move(picture.rgb);
    return pictures;
}

/// What a viewer gets that looks at these tiles at each moment.
std::string sent(const TileRecording& recording, const std::function<std::set<int>(double)>& looked_at) {
    TileSender sender(recording);
    std::string bytes;
    double last_s = 0;
    while (const auto due_s = sender.due_s()) {
        EXPECT_GE(*due_s, last_s);
        last_s = *due_s;
        sender.next(looked_at(last_s), bytes);
    }
    return bytes;
}

/// 8x4 tiles; of each 24 pictures at 30 a second in groups of 10.
class Tiles : public testing::Test {
protected:
    void make(const std::string& name, const std::string& preset) {
        made_.preset = preset;
        synthetic::write(folder_ / name, made_);
    }
    Pictures played(const std::string& bytes) const {
        std::ofstream(folder_ / "sent.mkv", std::ios::binary) << bytes;
        return pictures_of(folder_ / "sent.mkv");
    }
    static std::size_t track_of(int tile) { return std::size_t(tile + 1); }

    synthetic::Folder folder_;
    synthetic::MadeTiles made_{.grid = {8, 4}, .pictures = 24, .gop = 10};
};

TEST_F(Tiles, AreFoundByTheirTracks) {
    for (const char* name : {"a.mkv", "a.mp4"}) {
        make(name, "ultrafast");
        const auto recording = open_tiles((folder_ / name).string());
        ASSERT_TRUE(recording);
        EXPECT_EQ(recording->grid, made_.grid);
        EXPECT_EQ(recording->first.index, made_.first_index);
        ASSERT_EQ(recording->tiles.size(), 33u);
        EXPECT_FALSE(recording->tiles.front());
        for (int tile = 0; tile < 32; ++tile)
            EXPECT_EQ(recording->tiles[track_of(tile)], tile);
        EXPECT_NEAR(recording->times.duration_s, 24 / 30.0, 2 * clock_s);
    }
    synthetic::write(folder_ / "none.mkv", synthetic::small_stream(Codec::h264, true));
    EXPECT_FALSE(open_tiles((folder_ / "none.mkv").string()));
    EXPECT_THROW(open_tiles((folder_ / "absent.mkv").string()), InputError);
}

TEST_F(Tiles, OfNoGridAreBadInput) {
    const auto expect_refused = [&](const std::vector<Camera>& windows, const std::string& why) {
        StreamSettings settings;
        settings.preset = "ultrafast";
        settings.tracks.assign(windows.size() + 1, {TrackRole::window, 64, 64});
        settings.tracks.front() = {TrackRole::main, 128, 64};
        StreamWriter writer((folder_ / "a.mkv").string(), settings);
        writer.write(TrackRole::main, ByteImage(128, 64, 3).view(), synthetic::info(128, 64, 0));
        for (std::size_t i = 0; i < windows.size(); ++i) {
            FrameInfo info = synthetic::info(64, 64, 0);
            info.camera = windows[i];
            writer.write(TrackRole::window, ByteImage(64, 64, 3).view(), info, i);
        }
        writer.finish();
        try {
            open_tiles((folder_ / "a.mkv").string());
            ADD_FAILURE() << why;
        } catch (const InputError& error) {
            EXPECT_EQ(std::string(error.what()),
                      (folder_ / "a.mkv").string() + ": expected tiles that are the parts of one sphere, found " + why);
        }
    };
    const WindowGrid grid{512, 256, 64, 64}, other{256, 128, 64, 64};
    const Camera first = window_camera(grid, {64, 0});
    expect_refused({first, window_camera(grid, {80, 0})}, "one of 64x64 that fits no grid");
    expect_refused({first, window_camera(grid, {64, 16})}, "one of 64x64 that fits no grid");
    expect_refused({first, window_camera(other, {64, 0})}, "tiles of other sizes");
    expect_refused({first, EquirectCamera{64, 64, {-0.3, 0.3, -0.3, 0.3}}}, "one of 64x64 that fits no grid");
    expect_refused({first, EquirectCamera{64, 64, {}}}, "one of 64x64 that fits no grid");
    expect_refused({first, EquirectCamera{64, 64, {0, 0.001, 0, 0.001}}}, "one of 64x64 that fits no grid");
    expect_refused({first, PerspectiveCamera{64, 64, 1}}, "a flat view");
    expect_refused({PerspectiveCamera{64, 64, 1}, PerspectiveCamera{64, 64, 1}}, "a flat view");
}

TEST_F(Tiles, ThatAreNotLookedAtAreSentOnce) {
    for (const auto& [name, preset, first_moment] : {std::tuple("a.mkv", "ultrafast", 1),
                                                     {"a.mkv", "veryfast", max_reordered},
                                                     {"a.mp4", "ultrafast", 1},
                                                     {"a.mp4", "veryfast", max_reordered}}) {
        SCOPED_TRACE(std::string(name) + ", " + preset);
        make(name, preset);
        const Pictures whole = pictures_of(folder_ / name);
        const auto recording = open_tiles((folder_ / name).string());
        const std::string all = sent(*recording, [&](double) { return std::set{9, 10}; });
        std::map<std::size_t, int> counts;
        for (const auto& [key, picture] : played(all)) {
            EXPECT_TRUE(std::ranges::equal(picture.samples(), whole.at(key).samples())) << key.first;
            ++counts[key.first];
        }
        for (std::size_t track = 0; track < 33; ++track) {
            const bool looked_at = track == 0 || track == track_of(9) || track == track_of(10);
            EXPECT_GE(counts[track], looked_at ? 24 : 1) << track;
            EXPECT_LE(counts[track], looked_at ? 24 : first_moment) << track;
        }
        EXPECT_LT(all.size(), std::filesystem::file_size(folder_ / name) * 3 / 5);
    }
}

TEST_F(Tiles, ThatComeIntoViewBeginWithTheirKeyFrame) {
    for (const auto& [name, preset] : {std::pair("a.mkv", "ultrafast"), {"a.mkv", "veryfast"}, {"a.mp4", "veryfast"}}) {
        SCOPED_TRACE(std::string(name) + ", " + preset);
        make(name, preset);
        const Pictures whole = pictures_of(folder_ / name);
        const auto recording = open_tiles((folder_ / name).string());
        // From the sixth picture of the second group on at another one, for some time.
        const auto pictures = played(sent(*recording, [&](double time_s) {
            const double picture = time_s * 30 + 0.5;
            return picture < 15 ? std::set{3} : picture < 18 ? std::set{20} : std::set{3, 7};
        }));
        for (const auto& [key, picture] : pictures)
            EXPECT_TRUE(std::ranges::equal(picture.samples(), whole.at(key).samples()))
                << key.first << ", " << key.second;
        const auto has = [&](int tile, int ordinal) {
            return pictures.contains({track_of(tile), made_.first_index + ordinal});
        };
        for (int ordinal = 0; ordinal < 24; ++ordinal) {
            EXPECT_TRUE(has(3, ordinal)) << ordinal << ": what was let go by is made up for, within its group";
            const bool begins = ordinal > max_reordered && ordinal < 10, late = ordinal >= 20 + max_reordered;
            EXPECT_FALSE((begins || late) && has(20, ordinal)) << ordinal;
            EXPECT_FALSE(begins && has(7, ordinal)) << ordinal;
            EXPECT_TRUE(ordinal < 10 || ordinal >= 18 - max_reordered || has(20, ordinal)) << ordinal;
            EXPECT_TRUE(ordinal < 10 || has(7, ordinal)) << ordinal << ": from the key frame on";
        }
    }
}

/// 8 MiB of each tile are kept while nobody looks at it: fewer pictures than these groups have.
TEST_F(Tiles, OfGroupsTooLongToBeKeptWaitForTheNextKeyFrame) {
    constexpr TileGrid two{2, 1};
    constexpr int pictures = 140, gop = 135;
    const WindowGrid grid = tile_grid(512, two);
    StreamSettings settings;
    settings.preset = "ultrafast";
    settings.gop = gop;
    settings.pictures = pictures;
    settings.tracks.assign(3, {TrackRole::window, 256, 256, {}, 1.0});
    settings.tracks.front() = {TrackRole::main, 128, 64};
    std::mt19937 random(1);
    {
        StreamWriter writer((folder_ / "a.mkv").string(), settings);
        for (std::int64_t index = 0; index < pictures; ++index) {
            writer.write(TrackRole::main, synthetic::picture(128, 64, index).view(), synthetic::info(128, 64, index));
            for (int tile = 0; tile < 2; ++tile) {
                ByteImage noise(256, 256, 3);
                for (std::uint8_t& sample : noise.samples())
                    sample = std::uint8_t(random());
                FrameInfo info = synthetic::info(256, 256, index);
                info.camera = window_camera(grid, tile_place(grid, two, tile));
                writer.write(TrackRole::window, noise.view(), info, std::size_t(tile));
            }
        }
        writer.finish();
    }
    ASSERT_GT(std::filesystem::file_size(folder_ / "a.mkv"), 19u << 20) << "8 MiB of each tile before picture 125";
    const auto recording = open_tiles((folder_ / "a.mkv").string());
    const Pictures found = played(sent(*recording, [](double time_s) {
        return time_s * 30 + 0.5 < 125 ? std::set{1} : std::set{0, 1};
    }));
    for (std::int64_t index = 0; index < pictures; ++index) {
        EXPECT_TRUE(found.contains({2, index})) << index << ": of who looked all the time nothing is lost";
        EXPECT_EQ(found.contains({1, index}), index == 0 || index >= gop) << index;
    }
}

}  // namespace
}  // namespace equistream
