/// Sequences that are written, gone on with, put together of parts, and refused.
#include "frame_fixture.h"

#include <equistream/error.h>
#include <equistream/sequence_writer.h>

#include <string>
#include <utility>

namespace equistream::testing {
namespace {

class SequenceWriting : public FolderTest {
protected:
    SequenceSettings settings() const {
        SequenceSettings settings;
        settings.folder = folder / "out";
        settings.manifest.shared = test_info(4, 4);
        settings.manifest.fingerprint = "1";
        return settings;
    }
    template <typename Work>
    static std::string refusal(const Work& work) {
        try {
            work();
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    }
};

TEST_F(SequenceWriting, names_that_a_manifest_cannot_hold_are_refused) {
    for (const auto& [name, field] :
         {std::pair("scene_name", &FrameInfo::scene), std::pair("host_name", &FrameInfo::host),
          std::pair("geometry_fingerprint", &FrameInfo::geometry_fingerprint)}) {
        SequenceSettings wrong = settings();
        wrong.manifest.shared.*field = "caf\xe9";
        EXPECT_EQ(refusal([&] { SequenceWriter{wrong}; }),
                  std::string(name) + ": expected UTF-8, as a manifest holds it, found \"caf\xef\xbf\xbd\"");
    }
    EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

TEST_F(SequenceWriting, what_readers_refuse_is_not_written) {
    SequenceWriter writer(settings());
    Frame frame = test_frame(4, 4);
    frame.info.index = max_frame_index + 1;
    EXPECT_EQ(refusal([&] { writer.write(frame); }), (folder / "out/frame.1000000000.exr").string() +
                                                         ": frame number: expected a number from 0 to 999999999, " +
                                                         "found 1e+09");
    frame.info.index = 1;
    frame.info.time_s = 1e11;
    EXPECT_EQ(refusal([&] { writer.write(frame); }),
              (folder / "out/frame.0001.exr").string() +
                  ": frame time: expected a number from -1e+10 to 1e+10, found 1e+11");
    EXPECT_TRUE(list_frames(folder / "out").empty());
    frame.info.time_s = 1;
    writer.write(frame);
    EXPECT_EQ(read_manifest(folder / "out").shared.index, 1);
}

TEST_F(SequenceWriting, a_second_writer_keeps_what_is_whole_and_of_its_settings) {
    Frame frame = test_frame(4, 4);
    {
        SequenceWriter writer(settings());
        for (const int index : {5, 3, 4}) {
            frame.info.index = index;
            frame.info.time_s = index;
            frame.info.head.position_m.x = index;
            writer.write(frame);
        }
    }
    const FrameInfo first = read_manifest(folder / "out").shared;
    EXPECT_EQ(first.index, 3);
    EXPECT_EQ(first.time_s, 3);
    EXPECT_EQ(first.head.position_m.x, 3);
    const auto cut = folder / "out" / frame_file_name(4);
    {
        const SequenceWriter again(settings());
        for (const int index : {3, 4, 5})
            EXPECT_TRUE(again.keeps_frame(index)) << index;
        EXPECT_FALSE(again.keeps_frame(6));
        EXPECT_FALSE(again.keeps_frame(-1));
        const std::string whole = file_bytes(cut);
        put_bytes(cut, whole.substr(0, whole.size() - 1));
        EXPECT_FALSE(again.keeps_frame(4));
        EXPECT_THROW(require_whole_exr(cut), InputError);
        EXPECT_THROW(check_exr_pixels(cut), InputError);
        put_bytes(cut, whole);
        EXPECT_NO_THROW(check_exr_pixels(cut));
    }
    const std::string manifest = (folder / "out/manifest.json").string();
    SequenceSettings others = settings();
    others.manifest.shared.seed += 1;
    EXPECT_EQ(refusal([&] { SequenceWriter{others}; }),
              manifest + ": expected seed 18364758544493064720 as in the frames there, found 18364758544493064721; " +
                  "choose another folder or overwrite");
    others = settings();
    others.manifest.fingerprint = "2";
    EXPECT_EQ(refusal([&] { SequenceWriter{others}; }),
              manifest +
                  ": expected fingerprint 1 as in the frames there, found 2 (the scene, the path or the host's " +
                  "own settings changed); choose another folder or overwrite");
    others.overwrite = true;
    SequenceWriter over(others);
    EXPECT_FALSE(over.keeps_frame(5));
    EXPECT_EQ(list_frames(folder / "out"), (std::vector<std::int64_t>{3, 4, 5}));
    frame.info.index = 9;
    over.write(frame);
    EXPECT_EQ(list_frames(folder / "out"), std::vector<std::int64_t>{9});
    EXPECT_EQ(read_manifest(folder / "out").shared.index, 9);
}

TEST_F(SequenceWriting, frames_that_are_overwritten_one_by_one_keep_the_first_ones_pose) {
    Frame frame = test_frame(4, 4);
    for (const int index : {3, 7}) {
        SequenceSettings overwriting = settings();
        overwriting.overwrite = index == 7;
        SequenceWriter writer(overwriting);
        frame.info.index = index;
        frame.info.time_s = index;
        writer.write(frame);
    }
    EXPECT_EQ(read_manifest(folder / "out").shared.index, 3);
    EXPECT_EQ(read_manifest(folder / "out").shared.time_s, 3);
    EXPECT_EQ(list_frames(folder / "out"), (std::vector<std::int64_t>{3, 7}));
}

TEST_F(SequenceWriting, parts_come_back_whole_or_not_at_all) {
    const FrameInfo info = test_info(4, 4);
    const auto brought = [](std::uint32_t number) { return std::string("tiles\0 of ", 10) + std::to_string(number); };
    SequenceSettings of_parts = settings();
    of_parts.part.count = 2;
    of_parts.tile_side = 32;
    for (const std::uint32_t number : {1u, 2u}) {
        of_parts.part.number = number;
        SequenceWriter writer(of_parts);
        EXPECT_FALSE(writer.keeps_frame(41));
        writer.write_part(info, brought(number));
        EXPECT_TRUE(writer.keeps_frame(41));
        EXPECT_FALSE(writer.keeps_frame(42));
    }
    of_parts.part.number = 0;
    const SequenceWriter whole(of_parts);
    const std::size_t size = brought(1).size();
    for (const std::uint32_t number : {1u, 2u})
        EXPECT_EQ(whole.read_part(41, number, size), brought(number));
    const auto file = folder / "out/part-1-of-2/frame.0041.part";
    EXPECT_EQ(refusal([&] { whole.read_part(41, 1, size + 1); }).find(file.string() + ": expected "), 0u);
    EXPECT_NE(refusal([&] { whole.read_part(42, 1, size); }), "");
    const std::string good = file_bytes(file), short_by_one = good.substr(0, good.size() - 1);
    for (const std::string& bad : {short_by_one, short_by_one + "9", good + "1", std::string(1000, 'x')}) {
        put_bytes(file, bad);
        EXPECT_NE(refusal([&] { whole.read_part(41, 1, size); }), "");
    }
    whole.remove_parts(41);
    EXPECT_FALSE(std::filesystem::exists(folder / "out/part-1-of-2"));
    EXPECT_FALSE(std::filesystem::exists(folder / "out/part-2-of-2"));
}

TEST_F(SequenceWriting, a_part_is_kept_where_its_frame_was_put_together) {
    Frame frame = test_frame(4, 4);
    {
        SequenceWriter writer(settings());
        writer.write(frame);
    }
    SequenceSettings part = settings();
    part.part = {1, 2};
    part.tile_side = 32;
    EXPECT_TRUE(SequenceWriter(part).keeps_frame(41));
    EXPECT_FALSE(SequenceWriter(part).keeps_frame(42));
    part.manifest.shared.seed += 1;
    EXPECT_NE(refusal([&] { SequenceWriter{part}; }), "");
}

TEST_F(SequenceWriting, frames_of_other_settings_go_although_one_could_not_be_removed_at_first) {
    for (const int index : {1, 2, 3})
        std::filesystem::create_directories(folder / "out" / frame_file_name(index));
    const std::filesystem::path stuck = folder / "out" / frame_file_name(2) / "something";
    put_bytes(stuck, "");
    SequenceSettings overwriting = settings();
    overwriting.overwrite = true;
    SequenceWriter writer(overwriting);
    Frame frame = test_frame(4, 4);
    frame.info.index = 7;
    EXPECT_THROW(writer.write(frame), std::exception);
    EXPECT_EQ(list_frames(folder / "out"), (std::vector<std::int64_t>{1, 2}));
    std::filesystem::remove(stuck);
    writer.write(frame);
    EXPECT_EQ(list_frames(folder / "out"), std::vector<std::int64_t>{7});
}

}  // namespace
}  // namespace equistream::testing
