/// Tiles, put together to what eyes look through: of pictures at hand, and of streams.
#include <tests/unit/client/view/paced_server.h>
#include <tests/unit/plugin/stream/synthetic.h>

#include <client/receive/decoded_pictures.h>
#include <client/warp/engine.h>
#include <equistream/error.h>
#include <equistream/tile_stream.h>
#include <equistream/window.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <limits>
#include <memory>
#include <set>

namespace equistream::test {
namespace {

/// Tiles of 16x16 of a sphere of 128x64.
constexpr TileGrid tiles{8, 4};
const WindowGrid grid = tile_grid(128, tiles);
/// Whose pixels are not a whole number of the sphere's wide.
constexpr int base_columns = 48;

enum class Format { rgb, yuv, pq };

/// Another value at each place and of each channel, below 256.
template <typename T>
Image<T> ramp(int width, int height, int channels, int from) {
    Image<T> image(width, height, channels);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < channels; ++c)
                image.pixel(x, y)[c] = T((from + x + 2 * y + 40 * c) % 256);
    return image;
}

template <typename T>
Image<T> cut(const Image<T>& sphere, int x, int y, int width, int height) {
    Image<T> part(width, height, sphere.channels());
    for (int row = 0; row < height; ++row)
        for (int column = 0; column < width; ++column)
            std::copy_n(sphere.pixel((x + column) % sphere.width(), y + row), sphere.channels(),
                        part.pixel(column, row));
    return part;
}

template <typename T>
struct Planes {
    Image<T> y, cb, cr;
};
template <typename T>
Planes<T> ramps(int width, int height, int from) {
    return {ramp<T>(width, height, 1, from), ramp<T>(width / 2, height / 2, 1, from + 7),
            ramp<T>(width / 2, height / 2, 1, from + 13)};
}
template <typename T>
Yuv420Picture<const T> picture_of(Planes<T> made) {
    const auto planes = std::make_shared<const Planes<T>>(std::move(made));
    return {{planes->y.view(), planes->cb.view(), planes->cr.view()}, planes};
}
template <typename T>
Yuv420Picture<const T> cut(const Planes<T>& sphere, int x, int y, int width, int height) {
    return picture_of(Planes<T>{cut(sphere.y, x, y, width, height), cut(sphere.cb, x / 2, y / 2, width / 2, height / 2),
                                cut(sphere.cr, x / 2, y / 2, width / 2, height / 2)});
}

/// A whole sphere, of `from` another one, and any part of it.
ReceivedPicture part_of_sphere(Format format, int columns, int from, int x, int y, int width, int height) {
    ReceivedPicture part;
    part.info.index = 7;
    part.info.depth_code = DepthCodeInfo{DepthCodeId::w10, {0.0315, 1, true}, 0};
    part.info.camera = window_camera({columns, columns / 2, width, height}, {x, y});
    part.info.camera_pose.position_m = {1, 2, 3};
    if (format == Format::rgb)
        part.rgb = cut(ramp<std::uint8_t>(columns, columns / 2, 3, from), x, y, width, height);
    else if (format == Format::yuv)
        part.yuv = cut(ramps<std::uint8_t>(columns, columns / 2, from), x, y, width, height);
    else
        part.pq = cut(ramps<std::uint16_t>(columns, columns / 2, from), x, y, width, height);
    part.depth_m = cut(ramp<float>(columns, columns / 2, 1, from + 1), x, y, width, height);
    part.specular = cut(ramp<float>(columns, columns / 2, 1, from + 2), x, y, width, height);
    part.virtual_depth_m = cut(ramp<float>(columns, columns / 2, 1, from + 3), x, y, width, height);
    part.decode_ms = 2;
    part.convert_ms = 3;
    return part;
}
ReceivedPicture tile_of(Format format, int tile) {
    const WindowPlace place = tile_place(grid, tiles, tile);
    return part_of_sphere(format, grid.columns, 0, place.x, place.y, grid.width, grid.height);
}
ReceivedPicture base_of(Format format) {
    return part_of_sphere(format, base_columns, 100, 0, 0, base_columns, base_columns / 2);
}

ReceivedPicture join(Format format, const std::set<int>& numbers, PictureMemory* memory = nullptr) {
    std::vector<ReceivedPicture> given;
    for (const int number : numbers)
        given.push_back(tile_of(format, number));
    return join_tiles("a.mkv", std::move(given), base_of(format), memory);
}

/// Of the sphere wherever one of these tiles is, and else the base's pixel that its middle lies in.
template <typename T>
void expect_plane(ImageView<const T> found, const Image<T>& sphere, const Image<T>& base, WindowPlace place,
                  const std::set<int>& numbers) {
    const int shrunk = grid.columns / sphere.width();
    for (int y = 0; y < found.height; ++y)
        for (int x = 0; x < found.width; ++x) {
            const int column = (place.x / shrunk + x) % sphere.width(), row = place.y / shrunk + y;
            const int tile =
                row * tiles.rows / sphere.height() * tiles.columns + column * tiles.columns / sphere.width();
            const T* expected = numbers.contains(tile)
                                    ? sphere.pixel(column, row)
                                    : base.pixel((2 * column + 1) * base.width() / (2 * sphere.width()),
                                                 (2 * row + 1) * base.height() / (2 * sphere.height()));
            for (int c = 0; c < found.channels; ++c)
                ASSERT_EQ(found.pixel(x, y)[c], expected[c]) << x << ", " << y << ", tile " << tile;
        }
}
template <typename T>
void expect_planes(const Yuv420View<const T>& found, WindowPlace place, const std::set<int>& numbers) {
    const auto sphere = ramps<T>(grid.columns, grid.rows, 0), base = ramps<T>(base_columns, base_columns / 2, 100);
    expect_plane<T>(found.y, sphere.y, base.y, place, numbers);
    expect_plane<T>(found.cb, sphere.cb, base.cb, place, numbers);
    expect_plane<T>(found.cr, sphere.cr, base.cr, place, numbers);
}
void expect_distances(const FloatImage& found, int from, WindowPlace place, const std::set<int>& numbers) {
    expect_plane<float>(found.view(), ramp<float>(grid.columns, grid.rows, 1, from),
                        ramp<float>(base_columns, base_columns / 2, 1, 100 + from), place, numbers);
}

/// Where they lie, in tiles, and which.
struct Case {
    int column, row, across, down;
    std::set<int> numbers;
};

void expect_joined(Format format, const ReceivedPicture& all, const Case& expected) {
    const WindowPlace place{expected.column * grid.width, expected.row * grid.height};
    const WindowGrid joined{grid.columns, grid.rows, expected.across * grid.width, expected.down * grid.height};
    EXPECT_TRUE(same_camera(all.info.camera, window_camera(joined, place)));
    ASSERT_EQ(all.width(), joined.width);
    ASSERT_EQ(all.height(), joined.height);
    EXPECT_EQ(all.info.index, 7);
    EXPECT_TRUE(all.info.depth_code);
    EXPECT_EQ(all.decode_ms, 2 * double(expected.numbers.size()));
    EXPECT_EQ(all.convert_ms, 3 * double(expected.numbers.size()));
    if (format == Format::rgb)
        expect_plane<std::uint8_t>(all.rgb.view(), ramp<std::uint8_t>(grid.columns, grid.rows, 3, 0),
                                   ramp<std::uint8_t>(base_columns, base_columns / 2, 3, 100), place, expected.numbers);
    else if (format == Format::yuv)
        expect_planes<std::uint8_t>(all.yuv.planes, place, expected.numbers);
    else
        expect_planes<std::uint16_t>(all.pq.planes, place, expected.numbers);
    expect_distances(all.depth_m, 1, place, expected.numbers);
    expect_distances(all.specular, 2, place, expected.numbers);
    expect_distances(all.virtual_depth_m, 3, place, expected.numbers);
}

TEST(Tiles, JoinedAreTheirPartOfTheSphere) {
    std::set<int> every;
    for (int tile = 0; tile < tiles.count(); ++tile)
        every.insert(tile);
    for (const Format format : {Format::rgb, Format::yuv, Format::pq})
        for (const Case& expected : {Case{3, 1, 2, 2, {11, 12, 19, 20}},
                                     {7, 1, 2, 1, {8, 15}},              // across the seam
                                     {6, 0, 4, 2, {6, 7, 0, 1, 14, 8}},  // and with holes
                                     {2, 0, 3, 4, {2, 28}},              // a diagonal
                                     {0, 2, 8, 1, {16, 17, 18, 19, 20, 21, 22, 23}},
                                     {5, 3, 1, 1, {29}},
                                     {0, 0, 8, 4, every}}) {
            SCOPED_TRACE(std::to_string(int(format)) + ", from " + std::to_string(*expected.numbers.begin()));
            expect_joined(format, join(format, expected.numbers), expected);
        }
}

class Memory : public PictureMemory {
public:
    std::shared_ptr<std::uint8_t> take(std::size_t bytes) override {
        taken += bytes;
        if (full)
            return nullptr;
        void* memory = std::aligned_alloc(64, (bytes + 63) / 64 * 64);
        return {static_cast<std::uint8_t*>(memory), std::free};
    }
    std::atomic<std::size_t> taken = 0;
    bool full = false;
};

TEST(Tiles, LieWherePicturesAreWanted) {
    for (const bool full : {false, true})
        for (const Format format : {Format::yuv, Format::pq}) {
            Memory memory;
            memory.full = full;
            const Case expected{3, 1, 2, 2, {11, 12, 19, 20}};
            expect_joined(format, join(format, expected.numbers, &memory), expected);
            EXPECT_EQ(memory.taken, (format == Format::pq ? 2u : 1u) * 32 * 32 * 3 / 2);
        }
}

TEST(Tiles, LackWhatOneOfThemLacks) {
    std::vector<ReceivedPicture> given = {tile_of(Format::rgb, 1), tile_of(Format::rgb, 2)};
    given.back().depth_m = {};
    const ReceivedPicture all = join_tiles("a.mkv", std::move(given), base_of(Format::rgb), nullptr);
    EXPECT_TRUE(all.depth_m.empty());
    EXPECT_FALSE(all.info.depth_code);
    EXPECT_FALSE(all.specular.empty());
}

TEST(Tiles, FarApartAreRefusedWhereAllBetweenThemIsTooLarge) {
    constexpr int columns = 32736;
    std::vector<ReceivedPicture> given;
    for (const int y : {0, columns / 2 - 16})
        for (const int x : {0, 8176, 16368, 24544}) {
            ReceivedPicture tile;
            tile.info.camera = window_camera({columns, columns / 2, 16, 16}, {x, y});
            tile.rgb = ByteImage(16, 16, 3);
            given.push_back(std::move(tile));
        }
    try {
        join_tiles("a.mkv", std::move(given), base_of(Format::rgb), nullptr);
        ADD_FAILURE();
    } catch (const WorkError& error) {
        EXPECT_TRUE(std::string(error.what()).starts_with("a.mkv: expected tiles within 268435456 pixels, found "))
            << error.what();
    }
}

TEST(Tiles, OfOtherSpheresAreRefused) {
    const std::string of_one = "a.mkv: expected tiles of one sphere and one format, found others",
                      parts = "a.mkv: expected tiles that are parts of one sphere, found one of ";
    const auto expect_refused = [](const ReceivedPicture& other, const std::string& why) {
        for (const bool first : {false, true})
            try {
                std::vector<ReceivedPicture> given = {tile_of(Format::rgb, 11), other};
                if (first)
                    std::swap(given.front(), given.back());
                join_tiles("a.mkv", std::move(given), base_of(Format::rgb), nullptr);
                ADD_FAILURE() << why;
            } catch (const WorkError& error) {
                EXPECT_TRUE(std::string(error.what()).starts_with(why)) << error.what();
            }
    };
    ReceivedPicture moved = tile_of(Format::rgb, 12);
    moved.info.camera_pose.position_m.x += 0.01;
    expect_refused(moved, of_one);
    expect_refused(tile_of(Format::yuv, 12), of_one);
    expect_refused(tile_of(Format::pq, 12), of_one);
    ReceivedPicture flat = tile_of(Format::rgb, 12);
    flat.info.camera = PerspectiveCamera{16, 16, 1};
    expect_refused(flat, of_one);
    expect_refused(part_of_sphere(Format::rgb, 128, 0, 64, 16, 32, 16), parts + "another size or place");
    expect_refused(part_of_sphere(Format::rgb, 256, 0, 64, 16, 16, 16), parts + "another size or place");
    ReceivedPicture smaller = tile_of(Format::rgb, 12);
    smaller.rgb = ByteImage(8, 8, 3);
    expect_refused(smaller, parts + "another size or place");
    const auto refused_alone = [&](LongitudeLatitudeRange range) {
        ReceivedPicture alone = tile_of(Format::rgb, 12);
        alone.info.camera = EquirectCamera{16, 16, range};
        EXPECT_THROW(join_tiles("a.mkv", {alone}, base_of(Format::rgb), nullptr), WorkError);
    };
    const LongitudeLatitudeRange sound = window_range(grid, {64, 16});
    refused_alone({sound.longitude_min + 0.1, sound.longitude_max + 0.1, sound.latitude_min, sound.latitude_max});
    refused_alone({sound.longitude_min, sound.longitude_max, sound.latitude_min - 0.01, sound.latitude_max});
    refused_alone({0, 0.001, 0, 0.001});
    refused_alone({0, 2 * pi, -pi / 2, pi / 2});
    refused_alone({0, 0, 0, 0});
    const double nan = std::numeric_limits<double>::quiet_NaN();
    refused_alone({nan, nan, nan, nan});
}

/// Streams of tiles of 64x64 of a sphere of 256x128.
class StreamedTiles : public testing::Test {
protected:
    std::string write(const std::string& name, const synthetic::MadeTiles& made) const {
        synthetic::write(folder_ / name, made);
        return (folder_ / name).string();
    }
    /// The whole sphere, as all tiles make it.
    static void expect_whole(const ReceivedFrame& frame, const synthetic::MadeTiles& made, std::int64_t index) {
        SCOPED_TRACE(index);
        EXPECT_FALSE(frame.base) << "none of it would be seen";
        FrameInfo expected = synthetic::info(256, 128, index);
        EXPECT_EQ(frame.main.info.index, index);
        EXPECT_TRUE(same_camera(frame.main.info.camera, expected.camera));
        EXPECT_TRUE(same_pose(frame.main.info.camera_pose, expected.camera_pose)) << "as main has it";
        EXPECT_TRUE(same_pose(frame.main.info.head, expected.head));
        EXPECT_EQ(frame.main.info.time_s, expected.time_s);
        EXPECT_EQ(frame.main.info.seed, expected.seed);
        EXPECT_GT(synthetic::psnr_db(frame.main.rgb, synthetic::picture(256, 128, index)), 33);
        ASSERT_EQ(frame.main.depth_m.empty(), !made.depth);
        if (made.depth) {
            EXPECT_NEAR(*frame.main.depth_m.pixel(100, 30), synthetic::tile_depth_m(1), 0.1);
            EXPECT_NEAR(*frame.main.depth_m.pixel(200, 90), synthetic::tile_depth_m(7), 0.1);
        }
    }

    synthetic::Folder folder_;
};

TEST_F(StreamedTiles, OfAFileComeWithEachFrameAfterASeekToo) {
    for (const char* name : {"a.mkv", "a.mp4", "a.ts"})
        for (const char* preset : {"ultrafast", "veryfast"}) {
            SCOPED_TRACE(std::string(name) + ", " + preset);
            const synthetic::MadeTiles made{.preset = preset, .depth = true};
            const auto feed = open_feed(write(name, made), {.depth = true});
            for (std::int64_t index = 5; index < 15; ++index)
                expect_whole(feed->next().value(), made, index);
            EXPECT_FALSE(feed->next());
            EXPECT_EQ(feed->truncation(), "");
            for (const std::int64_t wanted : {11, 6, 14, 5}) {
                ASSERT_TRUE(feed->seek(wanted));
                for (std::int64_t index = wanted; index < 15; ++index)
                    expect_whole(feed->next().value(), made, index);
                EXPECT_FALSE(feed->next());
                EXPECT_EQ(feed->truncation(), "");
            }
        }
}

TEST_F(StreamedTiles, AreOneTrackOfTheFeed) {
    const synthetic::MadeTiles made{.depth = true};
    const std::string file = write("a.mkv", made);
    std::int64_t bytes = 0;
    StreamReader reader(file);
    while (const auto picture = reader.next())
        bytes += picture->role == TrackRole::window ? picture->bytes : 0;
    const auto feed = open_feed(file, {.depth = true});
    while (feed->next()) {
    }
    std::vector<std::pair<std::string, std::int64_t>> found;
    for (const FeedTrack& track : feed->tracks())
        found.emplace_back(track.name, track.pictures);
    EXPECT_EQ(found, (std::vector<std::pair<std::string, std::int64_t>>{
                         {"main", 10}, {"window", 80}, {"window-depth", 80}, {"depth", 10}}));
    EXPECT_EQ(feed->tracks()[1].bytes, bytes);
}

/// What an mp4 says of its tracks, and of a group's pictures, is long where there are many.
TEST_F(StreamedTiles, MayBeManyAndTheirGroupsLong) {
    for (const auto& made :
         {synthetic::MadeTiles{.grid = {8, 4}, .codec = Codec::h265, .pictures = 2},
          synthetic::MadeTiles{.grid = {2, 1}, .preset = "superfast", .pictures = 3000, .gop = 3000}}) {
        StreamReader reader(write("a.mp4", made), {.rgb = false});
        int pictures = 0;
        while (reader.next())
            ++pictures;
        EXPECT_EQ(pictures, (made.grid.count() + 1) * made.pictures);
        EXPECT_EQ(reader.truncation(), "");
    }
}

TEST_F(StreamedTiles, ComeAsTheDecodersPlanes) {
    const synthetic::MadeTiles made{.pictures = 5};
    const auto memory = std::make_shared<Memory>();
    const auto feed = open_feed(write("a.mkv", made), {.memory = memory, .yuv = true});
    const auto as_rgb = open_feed(write("a.mkv", made));
    while (const auto frame = feed->next()) {
        ASSERT_FALSE(frame->main.yuv.empty());
        EXPECT_FALSE(frame->base);
        const ByteImage luma = luma_of(as_rgb->next()->main.rgb.view());
        double worst = 0;
        for (int y = 0; y < 128; ++y)
            for (int x = 0; x < 256; ++x)
                worst = std::max(worst, std::abs(double(*frame->main.yuv.planes.y.pixel(x, y)) - *luma.pixel(x, y)));
        EXPECT_LT(worst, 8);
    }
    EXPECT_FALSE(as_rgb->next());
    EXPECT_GT(memory->taken, 5u * 256 * 128 * 3 / 2);
}

/// The second tile's depth ends with the first frame: eyes need that of all that they look through.
TEST_F(StreamedTiles, WithoutTheDepthThatTheirBaseHasAreLeftOut) {
    const synthetic::MadeTiles made{.grid = {2, 1}};
    StreamSettings settings;
    settings.preset = "ultrafast";
    const TrackSettings base_m{TrackRole::depth, 128, 64, DepthCodeId::w10}, tile{TrackRole::window, 64, 64},
        tile_m{TrackRole::window_depth, 64, 64, DepthCodeId::w10};
    settings.tracks = {{TrackRole::main, 128, 64}, base_m, tile, tile_m, tile, tile_m};
    StreamWriter writer((folder_ / "a.mkv").string(), settings);
    for (const std::int64_t index : {0, 1, 2})
        for (const int number : {0, 1}) {
            FrameInfo whole = synthetic::info(128, 64, index), part = synthetic::tile_info(made, number, index);
            if (number == 0)
                writer.write(TrackRole::main, ByteImage(128, 64, 3, 99).view(), whole);
            writer.write(TrackRole::window, ByteImage(64, 64, 3, 99).view(), part, std::size_t(number));
            whole.depth_code = part.depth_code = DepthCodeInfo{DepthCodeId::w10, {0.0315, 1, true}, 0};
            if (number == 0)
                writer.write_depth(TrackRole::depth, FloatImage(128, 64, 1, 3).view(), whole);
            if (number == 0 || index == 0)
                writer.write_depth(TrackRole::window_depth, FloatImage(64, 64, 1, 2).view(), part, std::size_t(number));
        }
    writer.finish();
    for (const bool depth : {true, false}) {
        const auto feed = open_feed((folder_ / "a.mkv").string(), {.depth = depth});
        for (const std::int64_t index : {0, 1, 2}) {
            const ReceivedPicture main = feed->next().value().main;
            EXPECT_TRUE(main.width() == (depth && index > 0 ? 64 : 128) && main.depth_m.empty() != depth) << index;
        }
    }
}

/// Makes main's frame data in one picture unknown, by its number in coded order: that is damaged then.
void lose_main(std::string& bytes, int number) {
    constexpr std::size_t role_at = 20;
    const auto payload = encode_frame_info(TrackRole::main, synthetic::info(128, 64, 0));
    const std::string uuid(payload.begin(), payload.begin() + 16);
    for (auto at = bytes.find(uuid); at != std::string::npos; at = bytes.find(uuid, at + 1))
        if (std::uint8_t(bytes.at(at + role_at)) == payload[role_at] && number-- == 0)
            bytes[at] ^= 0x55;
    EXPECT_LT(number, 0);
}

/// The server goes on with later frames and is silent then.
TEST_F(StreamedTiles, ThatNobodyLooksAtAreNotWaitedForAfterTheLastFrame) {
    const auto recording = open_tiles(write("a.mkv", {.depth = true}));
    TileSender sender(*recording);
    std::string sent;
    while (sender.due_s())
        sender.next({1}, sent);
    for (const bool last_is_lost : {false, true}) {
        SCOPED_TRACE(last_is_lost);
        if (last_is_lost)
            lose_main(sent, 6);
        PacedServer server;
        server.give({std::vector<char>(sent.begin(), sent.end())}, 0, 1);
        const auto feed = open_feed(server.address(), {.depth = true, .last_frame = 11});
        for (std::int64_t index = 5; index < (last_is_lost ? 11 : 12); ++index) {
            const auto frame = feed->next();
            ASSERT_TRUE(frame);
            EXPECT_EQ(frame->main.info.index, index);
            EXPECT_FALSE(frame->main.depth_m.empty());
        }
        EXPECT_FALSE(feed->next());
        EXPECT_EQ(feed->truncation(), "") << "it would say that the server was silent";
    }
}

TEST_F(StreamedTiles, AreLeftOutAsWindowsAre) {
    const auto left_out = [] { return TrackRoles().set(std::size_t(TrackRole::window)); };
    const auto feed = open_feed(write("a.mkv", {}), {.left_out = left_out});
    for (std::int64_t index = 5; index < 15; ++index) {
        const auto frame = feed->next().value();
        EXPECT_EQ(frame.main.info.index, index);
        EXPECT_EQ(frame.main.width(), 128);
        EXPECT_FALSE(frame.base);
    }
    EXPECT_FALSE(feed->next());
}

}  // namespace
}  // namespace equistream::test
