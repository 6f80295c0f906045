// Frames appear whole or not at all; a sequence resumes only with the settings it was begun with.
#include "abi_fixture.h"

#include <tests/comma_locale.h>

namespace equistream::testing {
namespace {

class AbiSequence : public AbiTest {
protected:
    void render(es_sequence* sequence, std::int64_t index, float red = 0.5f) {
        es_frame* frame = begin(sequence, at(index));
        fill(frame, miss, [&](const es_ray&) { return glm::vec4(red, 0, 0, 1); });
        end(frame);
    }
    std::size_t files() const {
        return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(output), {}));
    }
};

TEST_F(AbiSequence, resumes_where_it_stopped) {
    es_sequence* sequence = open();
    render(sequence, 3);
    es_sequence_close(sequence);
    sequence = open();
    EXPECT_NE(es_sequence_has_frame(sequence, 3), 0);
    EXPECT_EQ(es_sequence_has_frame(sequence, 4), 0);
    render(sequence, 4);
    es_sequence_close(sequence);
    EXPECT_EQ(list_frames(output), (std::vector<std::int64_t>{3, 4}));
    EXPECT_EQ(read_manifest(output).shared.index, 3) << "poses are those of the first frame";
}

TEST_F(AbiSequence, a_cut_or_empty_frame_is_not_finished) {
    es_sequence* sequence = open();
    render(sequence, 0);
    render(sequence, 1);
    es_sequence_close(sequence);
    const std::filesystem::path file = output + "/frame.0001.exr";
    const std::string whole = file_bytes(file);
    for (const std::size_t length : {std::size_t{0}, std::size_t{100}, whole.size() / 2, whole.size() - 1}) {
        put_bytes(file, whole.substr(0, length));
        sequence = open();
        EXPECT_NE(es_sequence_has_frame(sequence, 0), 0);
        EXPECT_EQ(es_sequence_has_frame(sequence, 1), 0) << length << " of " << whole.size() << " bytes";
        render(sequence, 1);
        EXPECT_NE(es_sequence_has_frame(sequence, 1), 0);
        es_sequence_close(sequence);
        EXPECT_EQ(file_bytes(file), whole) << "rendered anew";
    }
}

TEST_F(AbiSequence, the_manifest_has_the_poses_of_the_lowest_frame_whenever_that_comes) {
    const auto begins_at = [&] {
        const FrameInfo first = read_manifest(output).shared;
        EXPECT_EQ(first.time_s, static_cast<double>(first.index) / 30);
        return first.index;
    };
    es_sequence* sequence = open();
    render(sequence, 7);
    EXPECT_EQ(begins_at(), 7);
    render(sequence, 9);
    EXPECT_EQ(begins_at(), 7);
    render(sequence, 6);
    EXPECT_EQ(begins_at(), 6);
    es_sequence_close(sequence);
    sequence = open();
    render(sequence, 8);
    EXPECT_EQ(begins_at(), 6);
    render(sequence, 3);
    EXPECT_EQ(begins_at(), 3);
    es_sequence_close(sequence);
    settings.overwrite = 1;
    settings.command = "again";
    sequence = open();
    render(sequence, 7);
    EXPECT_EQ(begins_at(), 3) << "frame 3 is still there";
    EXPECT_EQ(read_manifest(output).command, "again");
    es_sequence_close(sequence);
    settings.seed = 12;
    sequence = open();
    render(sequence, 8);
    EXPECT_EQ(begins_at(), 8) << "all others have gone";
    es_sequence_close(sequence);
}

TEST_F(AbiSequence, other_settings_are_refused_and_named) {
    es_sequence* sequence = open();
    render(sequence, 0);
    es_sequence_close(sequence);
    const std::string before = file_bytes(output + "/frame.0000.exr");
    const std::string where = output + "/manifest.json: expected ";
    const std::string tail = "; choose another folder or overwrite";
    settings.spp = 8;
    EXPECT_EQ(refusal(), where + "spp 4 as in the frames there, found 8" + tail);
    settings.spp = 4;
    settings.width = 73;
    EXPECT_EQ(refusal(), where + "size 72x36 as in the frames there, found 73x36" + tail);
    settings.width = 72;
    settings.aovs = "depth";
    EXPECT_NE(refusal().find("found colour,depth"), std::string::npos);
    settings.aovs = "all";
    settings.camera = ES_PERSPECTIVE;
    EXPECT_NE(refusal().find("camera equirect"), std::string::npos);
    settings.camera = ES_EQUIRECT;
    settings.host_name = "test host, rebuilt";
    EXPECT_EQ(refusal(), where + "host_name \"test host\" as in the frames there, found \"test host, rebuilt\"" +
                             " (another renderer, or its code has changed)" + tail);
    settings.host_name = "test host";
    settings.fingerprint = "abd";
    EXPECT_NE(refusal().find("expected fingerprint"), std::string::npos);
    EXPECT_EQ(file_bytes(output + "/frame.0000.exr"), before);
}

TEST_F(AbiSequence, overwriting_takes_nothing_for_a_frame_that_cannot_be_written) {
    es_sequence* sequence = open();
    render(sequence, 3);
    render(sequence, 4);
    es_sequence_close(sequence);
    const std::string manifest = file_bytes(output + "/manifest.json");
    settings.seed = 12;
    settings.overwrite = 1;
    sequence = open();
    const std::filesystem::path aside = output + "/.frame.0003.exr.aside";
    std::filesystem::create_symlink("elsewhere", aside);
    es_frame* frame = begin(sequence, at(3));
    fill(frame, miss, black);
    es_error error{};
    EXPECT_EQ(es_frame_end(frame, &error), ES_FAILED) << error.text;
    EXPECT_EQ(list_frames(output), (std::vector<std::int64_t>{3, 4}));
    EXPECT_EQ(file_bytes(output + "/manifest.json"), manifest);
    std::filesystem::remove(aside);
    render(sequence, 3);
    es_sequence_close(sequence);
    EXPECT_EQ(list_frames(output), (std::vector<std::int64_t>{3}));
}

TEST_F(AbiSequence, names_that_a_manifest_cannot_hold_are_refused) {
    settings.scene_name = "caf\xe9";
    EXPECT_EQ(refusal(), "scene_name: expected UTF-8, as a manifest holds it, found \"caf\xef\xbf\xbd\"");
    settings.scene_name = "caf\xc3\xa9";
    settings.command = "render caf\xe9.json";
    es_sequence_close(open());
    es_sequence_close(open());
}

TEST_F(AbiSequence, frames_and_manifest_name_the_geometry) {
    settings.geometry_fingerprint = "g1";
    es_sequence* sequence = open();
    render(sequence, 0);
    es_sequence_close(sequence);
    EXPECT_EQ(read_manifest(output).shared.geometry_fingerprint, "g1");
    EXPECT_EQ(read_exr_info(output + "/frame.0000.exr").geometry_fingerprint, "g1");
    sequence = open();
    render(sequence, 1);
    es_sequence_close(sequence);
    EXPECT_EQ(read_exr_info(output + "/frame.0001.exr").geometry_fingerprint, "g1");
    settings.geometry_fingerprint = "g2";
    EXPECT_NE(refusal().find("expected geometry_fingerprint \"g1\" as in the frames there, found \"g2\""),
              std::string::npos);
}

TEST_F(AbiSequence, overwriting_with_other_settings_removes_their_frames) {
    es_sequence* sequence = open();
    render(sequence, 0);
    render(sequence, 1);
    es_sequence_close(sequence);
    put_bytes(output + "/notes.txt", "mine");
    settings.overwrite = 1;
    sequence = open();
    EXPECT_EQ(es_sequence_has_frame(sequence, 0), 0);
    EXPECT_EQ(list_frames(output).size(), 2u) << "the same settings: frames stay until they are rendered again";
    es_sequence_close(sequence);
    settings.seed = 12;
    sequence = open();
    EXPECT_EQ(list_frames(output).size(), 2u) << "opening takes nothing away";
    EXPECT_EQ(es_sequence_has_frame(sequence, 0), 0);
    render(sequence, 1);
    EXPECT_EQ(list_frames(output), std::vector<std::int64_t>{1})
        << "the first new frame takes the place of all old ones";
    EXPECT_EQ(read_manifest(output).shared.seed, 12u);
    EXPECT_TRUE(std::filesystem::exists(output + "/notes.txt"));
    es_sequence_close(sequence);
}

TEST_F(AbiSequence, frames_without_a_manifest_are_not_added_to) {
    std::filesystem::create_directories(output);
    write_exr(output + "/frame.0000.exr", test_frame(4, 4));
    EXPECT_NE(refusal().find("expected a manifest beside the frames, found none"), std::string::npos);
    put_bytes(output + "/manifest.json", "{");
    EXPECT_NE(refusal().find("manifest.json: byte"), std::string::npos);
}

TEST_F(AbiSequence, an_unfinished_frame_is_refused_and_leaves_nothing) {
    es_sequence* sequence = open();
    es_frame* frame = begin(sequence, at(0));
    es_tile tile{};
    ASSERT_EQ(es_frame_next_tile(frame, &tile), ES_OK);
    es_error error{};
    EXPECT_EQ(es_frame_end(frame, &error), ES_BAD_INPUT);
    EXPECT_STREQ(error.text, "frame 0: expected every plane finished, found plane colour unfinished in 6 of 6 tiles");
    frame = begin(sequence, at(0));
    es_frame_discard(frame);
    EXPECT_EQ(files(), 1u);
    es_sequence_close(sequence);
}

TEST_F(AbiSequence, misuse_of_a_tile_is_reported_at_the_end) {
    es_sequence* sequence = open();
    es_error error{};
    es_frame* frame = begin(sequence, at(0));
    fill(frame, miss, black);
    es_tile tile{};
    EXPECT_EQ(es_frame_next_tile(frame, &tile), ES_DONE);
    EXPECT_EQ(es_frame_next_tile(frame, &tile), ES_DONE);
    tile.id = 77;
    std::vector<float> rgba(32 * 32 * 4);
    es_tile_put_radiance(frame, &tile, rgba.data());
    EXPECT_EQ(es_frame_end(frame, &error), ES_BAD_INPUT);
    EXPECT_STREQ(error.text, "frame 0: es_tile_put_radiance: expected a tile of this frame, unchanged, found tile 77");

    frame = begin(sequence, at(0));
    ASSERT_EQ(es_frame_next_tile(frame, &tile), ES_OK);
    std::vector<es_ray> rays(tile.pixel_count);
    es_tile_colour_rays(frame, &tile, 4, rays.data());
    EXPECT_EQ(es_frame_end(frame, &error), ES_BAD_INPUT);
    EXPECT_STREQ(error.text, "frame 0: es_tile_colour_rays: sample: expected below 4, found 4");

    frame = begin(sequence, at(0));
    ASSERT_EQ(es_frame_next_tile(frame, &tile), ES_OK);
    for (int pass = 0; pass < 5; ++pass)
        es_tile_put_radiance(frame, &tile, rgba.data());
    EXPECT_EQ(es_frame_end(frame, &error), ES_BAD_INPUT);
    EXPECT_STREQ(error.text, "frame 0: es_tile_put_radiance: tile 0: expected 4 passes, found one more");
    es_sequence_close(sequence);
}

TEST_F(AbiSequence, a_frame_outlives_its_sequence) {
    es_sequence* sequence = open();
    es_frame* frame = begin(sequence, at(9));
    es_sequence_close(sequence);
    fill(frame, miss, black);
    end(frame);
    EXPECT_EQ(list_frames(output), std::vector<std::int64_t>{9});
}

TEST_F(AbiSequence, a_frame_that_cannot_be_written_is_a_failure) {
    es_sequence* sequence = open();
    es_frame* frame = begin(sequence, at(0));
    fill(frame, miss, black);
    std::filesystem::remove_all(output);
    es_error error{};
    EXPECT_EQ(es_frame_end(frame, &error), ES_FAILED);
    EXPECT_EQ(std::string(error.text), output + "/frame.0000.exr: cannot be written: No such file or directory");
    es_sequence_close(sequence);
}

TEST_F(AbiSequence, a_folder_belongs_to_one_sequence_at_a_time) {
    es_sequence* sequence = open();
    EXPECT_EQ(refusal(), output + ": expected a folder that no other process is writing to, found one in use: wait for "
                                  "the other process, or choose another folder");
    settings.overwrite = 1;
    settings.seed = 12;
    EXPECT_NE(refusal().find("in use"), std::string::npos) << "overwriting takes nothing from a render that goes on";
    es_frame* frame = begin(sequence, at(0));
    es_sequence_close(sequence);
    EXPECT_NE(refusal().find("in use"), std::string::npos) << "by the frame that is not ended yet";
    fill(frame, miss, black);
    end(frame);
    es_sequence_close(open());
}

TEST_F(AbiSequence, another_layout_of_files_is_refused) {
    es_sequence* sequence = open();
    render(sequence, 0);
    es_sequence_close(sequence);
    settings.single_part = 1;
    EXPECT_EQ(refusal(), output + "/manifest.json: expected single_part 0 as in the frames there, found 1; choose "
                                  "another folder or overwrite");
    settings.overwrite = 1;
    sequence = open();
    render(sequence, 1);
    es_sequence_close(sequence);
    EXPECT_EQ(list_frames(output), std::vector<std::int64_t>{1}) << "no mixture of both";
    EXPECT_EQ(read_manifest(output).single_part, true);
    settings.overwrite = 0;
    es_sequence_close(open());

    Manifest earlier = read_manifest(output);
    earlier.single_part.reset();
    write_manifest(output, earlier);
    es_sequence_close(open());
}

TEST_F(AbiSequence, single_part_files_when_asked) {
    settings.single_part = 1;
    es_sequence* sequence = open();
    render(sequence, 0);
    es_sequence_close(sequence);
    const std::string bytes = file_bytes(output + "/frame.0000.exr");
    EXPECT_EQ(bytes[5] & 0x10, 0) << "the multi-part bit of the version field";
}

TEST_F(AbiSequence, a_host_in_a_locale_with_a_decimal_comma_writes_what_any_other_writes) {
    const Pose turned{{0.25, 1.5, -1e9 / 7}, glm::normalize(glm::dquat(0.3, 0.1, -0.9, 0.2))};
    const auto write = [&] {
        es_sequence* sequence = open();
        for (const std::int64_t index : {0, 1})
            if (es_frame* frame = begin(sequence, at(index, turned, turned, turned))) {
                fill(frame, miss, black);
                end(frame);
            }
        es_sequence_close(sequence);
    };
    write();
    const std::string plain = file_bytes(output + "/frame.0001.exr");
    std::filesystem::remove(output + "/frame.0001.exr");
    {
        const CommaLocale locale;
        es_sequence* sequence = open();  // the same fingerprint: the sequence goes on
        ASSERT_NE(sequence, nullptr);
        EXPECT_EQ(es_sequence_has_frame(sequence, 0), 1);
        es_frame* frame = begin(sequence, at(1, turned, turned, turned));
        fill(frame, miss, black);
        end(frame);
        es_sequence_close(sequence);
    }
    EXPECT_TRUE(file_bytes(output + "/frame.0001.exr") == plain);
    const glm::dquat read = read_exr_info(output + "/frame.0001.exr").head.orientation;
    EXPECT_NEAR(read.y, turned.orientation.y, 1e-15);
}

}  // namespace
}  // namespace equistream::testing
