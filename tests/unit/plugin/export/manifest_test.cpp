#include "frame_fixture.h"

#include <equistream/aov_groups.h>
#include <equistream/error.h>
#include <equistream/locks.h>
#include <equistream/sequence_writer.h>
#include <equistream/window.h>

#include <tests/comma_locale.h>
#include <tests/unit/atlas_fixture.h>
#include <tests/unit/plugin/stream/synthetic.h>

#include <sys/stat.h>

#include <array>
#include <cerrno>
#include <functional>
#include <set>

namespace equistream::testing {
namespace {

class ManifestFile : public FolderTest {
protected:
    Manifest example() const {
        Manifest manifest;
        manifest.shared = test_info(960, 480);
        manifest.planes = {"colour", "depth"};
        manifest.command = "render \"a b\" \xff";
        manifest.fingerprint = "0123abcd";
        return manifest;
    }
    std::string refusal() const {
        try {
            read_manifest(folder);
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    }
};

TEST_F(ManifestFile, comes_back_exactly) {
    const Manifest written = example();
    write_manifest(folder, written);
    const Manifest read = read_manifest(folder);
    EXPECT_EQ(read.planes, written.planes);
    EXPECT_EQ(read.fingerprint, written.fingerprint);
    EXPECT_EQ(read.command, "render \"a b\" \xef\xbf\xbd");
    EXPECT_EQ(read.shared.seed, written.shared.seed);
    EXPECT_EQ(read.shared.time_s, written.shared.time_s);
    EXPECT_EQ(read.shared.frames_per_second, written.shared.frames_per_second);
    EXPECT_EQ(read.shared.head.orientation, written.shared.head.orientation);
    EXPECT_EQ(read.shared.camera_pose.position_m, written.shared.camera_pose.position_m);
    EXPECT_EQ(read.shared.eye, written.shared.eye);
    EXPECT_EQ(read.shared.lock, written.shared.lock);
    EXPECT_EQ(width_of(read.shared.camera), 960);
    EXPECT_EQ(read.shared.geometry_fingerprint, written.shared.geometry_fingerprint);
    EXPECT_EQ(read.single_part, std::nullopt);
}

TEST_F(ManifestFile, orientations_are_read_at_unit_length) {
    Manifest manifest = example();
    manifest.shared.camera_pose.orientation = {0.9991, 0, 0, 0};
    manifest.shared.head.orientation *= 1.0009;
    write_manifest(folder, manifest);
    const FrameInfo read = read_manifest(folder).shared;
    EXPECT_EQ(read.camera_pose.orientation, glm::dquat(1, 0, 0, 0));
    EXPECT_LT(glm::length(read.head.orientation - example().shared.head.orientation), 1e-15);
}

TEST_F(ManifestFile, what_not_every_sequence_has_comes_back) {
    Manifest written = example();
    FrameInfo& info = written.shared;
    info.denoiser = "oidn 2";
    info.accumulated_frames = 8;
    info.window_columns = 384;
    info.camera = window_shape({384, 192, 64, 48});
    write_manifest(folder, written);
    expect_same_info(read_manifest(folder).shared, info);

    info = test_info(500, 243);
    info.patches = random_atlas(3, 2, 1);
    write_manifest(folder, written);
    info.patches->slots.assign(6, {});  // which differ from frame to frame
    expect_same_info(read_manifest(folder).shared, info);

    info = test_info(64, 32);
    ASSERT_TRUE(make_ods(info));
    write_manifest(folder, written);
    expect_same_info(read_manifest(folder).shared, info);
}

/// Frames of one setting must not go on in a folder of another.
TEST_F(ManifestFile, the_fingerprint_tells_settings_apart) {
    std::set<std::string> told{sequence_fingerprint(example(), "host")};
    const auto expect_new = [&](const char* what, const std::function<void(Manifest&)>& change) {
        Manifest other = example();
        change(other);
        EXPECT_TRUE(told.insert(sequence_fingerprint(other, "host")).second) << what;
    };
    expect_new("samples", [](Manifest& m) { m.shared.samples_per_pixel += 1; });
    expect_new("seed", [](Manifest& m) { m.shared.seed += 1; });
    expect_new("exposure", [](Manifest& m) { m.shared.exposure += 0.5; });
    expect_new("planes", [](Manifest& m) { m.planes.push_back("motion"); });
    expect_new("scene", [](Manifest& m) { m.shared.scene += "2"; });
    expect_new("size", [](Manifest& m) { m.shared.camera = EquirectCamera{1920, 960, {}}; });
    expect_new("denoiser", [](Manifest& m) { m.shared.denoiser = "balanced"; });
    expect_new("history", [](Manifest& m) { m.shared.accumulated_frames = 8; });
    EXPECT_TRUE(told.insert(sequence_fingerprint(example(), "another host")).second);
    EXPECT_EQ(told.count(sequence_fingerprint(example(), "host")), 1u);
    Manifest commanded = example();
    commanded.command = "render otherwise";
    EXPECT_EQ(told.count(sequence_fingerprint(commanded, "host")), 1u);
}

TEST_F(ManifestFile, the_layout_of_the_files_comes_back_where_it_is_said) {
    Manifest manifest = example();
    for (const bool single_part : {false, true}) {
        manifest.single_part = single_part;
        write_manifest(folder, manifest);
        EXPECT_EQ(read_manifest(folder).single_part, single_part);
    }
    std::string text = file_bytes(folder / "manifest.json");
    text.replace(text.find("\"single_part\": true") + 15, 4, "1");
    put_bytes(folder / "manifest.json", text);
    EXPECT_EQ(refusal(), (folder / "manifest.json").string() + ": single_part: expected true or false, found 1");
}

class OneRenderOf : public FolderTest {
protected:
    static std::string refusal(OneRender& render, const FrameInfo& info) {
        try {
            render.require("f.exr", info);
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    }
    void expect_each_difference_named(OneRender& render, const std::string& as_in) const {
        FrameInfo info = test_info(64, 32);
        EXPECT_EQ(refusal(render, info), "");
        info.index = 2;
        info.camera_pose.position_m.x = 7;
        EXPECT_EQ(refusal(render, info), "") << "frames of one render differ in pose";
        const FrameInfo good = info;
        info.seed = 9;
        EXPECT_EQ(refusal(render, info), "f.exr: expected seed 18364758544493064720 as in " + as_in + ", found 9");
        info = good;
        info.samples_per_pixel = 8;
        EXPECT_EQ(refusal(render, info), "f.exr: expected spp 1000 as in " + as_in + ", found 8");
        info = good;
        info.host = "toy 1.3";
        EXPECT_EQ(refusal(render, info), "f.exr: expected host \"toy 1.2\" as in " + as_in + ", found \"toy 1.3\"");
        info.camera = EquirectCamera{64, 30, {}};
        EXPECT_EQ(refusal(render, info), "f.exr: expected 64x32 pixels as in " + as_in + ", found 64x30");
        info = good;
        info.camera = EquirectCamera{64, 32, {-1, 1, -1, 1}};
        EXPECT_NE(refusal(render, info).find("f.exr: expected camera {"), std::string::npos);
        info.camera = PerspectiveCamera{64, 32, 1};
        EXPECT_NE(refusal(render, info).find("\"kind\":\"perspective\""), std::string::npos);
    }
};

TEST_F(OneRenderOf, a_folder_is_what_its_manifest_says) {
    Manifest manifest;
    manifest.shared = test_info(64, 32);
    write_manifest(folder, manifest);
    OneRender render(folder);
    expect_each_difference_named(render, (folder / "manifest.json").string());
    FrameInfo other = test_info(64, 32);
    other.seed = 9;
    OneRender again(folder);
    EXPECT_NE(refusal(again, other), "") << "of the first frame too";
}

TEST_F(OneRenderOf, a_folder_without_a_manifest_is_what_its_first_frame_says) {
    OneRender render(folder);
    expect_each_difference_named(render, "the frames before it");
}

TEST_F(ManifestFile, earlier_ones_say_no_geometry) {
    write_manifest(folder, example());
    std::string text = file_bytes(folder / "manifest.json");
    const std::size_t key = text.find("\"geometry_fingerprint\"");
    ASSERT_NE(key, std::string::npos);
    text.erase(key, text.find('\n', key) - key);
    put_bytes(folder / "manifest.json", text);
    EXPECT_EQ(refusal(), "");
    EXPECT_EQ(read_manifest(folder).shared.geometry_fingerprint, "");
}

TEST_F(ManifestFile, every_truncation_is_an_error) {
    write_manifest(folder, example());
    const std::string text = file_bytes(folder / "manifest.json");
    for (std::size_t length = 0; length + 1 < text.size(); ++length) {
        put_bytes(folder / "manifest.json", text.substr(0, length));
        ASSERT_NE(refusal().find("manifest.json"), std::string::npos) << length;
    }
}

TEST_F(ManifestFile, wrong_values_are_named) {
    write_manifest(folder, example());
    const std::string text = file_bytes(folder / "manifest.json");
    const auto with = [&](const std::string& from, const std::string& to) {
        std::string changed = text;
        const std::size_t at = changed.find(from);
        EXPECT_NE(at, std::string::npos) << from;
        changed.replace(at, from.size(), to);
        put_bytes(folder / "manifest.json", changed);
        return refusal();
    };
    const std::string file = (folder / "manifest.json").string();
    EXPECT_EQ(with("\"eye\": \"left\"", "\"eye\": \"third\""),
              file + ": eye: expected one of centre ... right, found \"third\"");
    EXPECT_EQ(with("\"width\": 960", "\"width\": 0"),
              file + ": camera: width: expected a whole number from 1 to 32768, found 0");
    EXPECT_EQ(with("\"version\": 1", "\"version\": 2"), file + ": version: expected 1, found 2");
    EXPECT_EQ(with("\"ipd_m\": 0.0631", "\"ipd_m\": 1e19"),
              file + ": ipd_m: expected a number from 0 to 10, found 1e+19");
    EXPECT_EQ(with("-5.0", "1e19").find(file + ": first_frame: head: position_m: expected coordinates"), 0u);
    const std::string time = "\"time_s\": ";
    EXPECT_EQ(with(time, time + "1e11, \"other\": "),
              file + ": first_frame: time_s: expected a number from -1e+10 to 1e+10, found 100000000000.0");
    const std::string latitudes = "\"latitudes_rad\": ";
    EXPECT_EQ(with(latitudes, latitudes + "[0, 1e-9], \"others\": ")
                  .find(file + ": camera: latitudes_rad: expected an ascending range in radians, 0.001 to"),
              0u);
    EXPECT_EQ(with("\"seed\": ", "\"sead\": "), file + ": expected key \"seed\", found none");
    const std::string planes = "\"planes\": ";
    for (const char* wrong : {"\"colour\"", "null", "[1]", R"({"a":"colour"})"})
        EXPECT_EQ(with(planes, planes + wrong + ", \"others\": "),
                  file + ": planes: expected a list of plane names, found " + wrong);
    const std::string ods = "\"kind\": \"ods\"", equirect = "\"kind\": \"equirect\"";
    const std::string apart = "expected with camera ods, left or right eyes that are apart, found ";
    EXPECT_EQ(with(equirect, ods), "");
    EXPECT_EQ(with("\"ipd_m\": 0.0631", "\"ipd_m\": 0"), "");
    for (const auto& [key, from, to] : {std::array{"eye", "\"left\"", "\"centre\""}, {"ipd_m", "0.0631", "0"}}) {
        std::string changed = text;
        changed.replace(changed.find(equirect), equirect.size(), ods);
        const std::string before = "\"" + std::string(key) + "\": ";
        const std::size_t at = changed.find(before + from) + before.size();
        changed.replace(at, std::string(from).size(), to);
        put_bytes(folder / "manifest.json", changed);
        EXPECT_EQ(refusal(), file + ": " + key + ": " + apart + to);
    }
}

TEST_F(ManifestFile, nesting_is_bounded) {
    write_manifest(folder, example());
    std::string text = file_bytes(folder / "manifest.json");
    const std::string key = "\"seed\": ";
    const std::size_t half = 400000;
    text.insert(text.find(key) + key.size(), std::string(half, '[') + std::string(half, ']') + ", \"other\": ");
    put_bytes(folder / "manifest.json", text);
    EXPECT_EQ(refusal(), (folder / "manifest.json").string() + ": expected at most 32 levels of nesting, found more");
}

TEST(FrameNames, are_padded_and_listed_in_order) {
    EXPECT_EQ(frame_file_name(7), "frame.0007.exr");
    EXPECT_EQ(frame_file_name(123456, "png"), "frame.123456.png");
}

class FrameList : public FolderTest {};

TEST_F(FrameList, holds_finished_frames_only) {
    for (const char* name : {"frame.0010.exr", "frame.0002.exr", "frame.12345.exr", ".frame.0003.exr.aside",
                             "frame.3.exr", "frame.00004.exr", "frame.-001.exr", "frame.0005.png", "frame.x.exr",
                             "frame.1000000000.exr", "frame.9223372036854775807.exr"})
        put_bytes(folder / name, "");
    EXPECT_EQ(list_frames(folder), (std::vector<std::int64_t>{2, 10, 12345}));
    EXPECT_EQ(list_frames(folder, "png"), std::vector<std::int64_t>{5});
    EXPECT_THROW(list_frames(folder / "missing"), InputError);
}

TEST(AovGroups, are_parsed_in_catalogue_order) {
    EXPECT_EQ(parse_aov_groups("none"), std::vector<std::string>{"colour"});
    EXPECT_EQ(parse_aov_groups("motion, depth"), (std::vector<std::string>{"colour", "depth", "backward", "forward"}));
    EXPECT_EQ(parse_aov_groups("all").size(), aov_catalogue().size() - 9);
    EXPECT_EQ(parse_aov_groups("all,raw,guides,samples,variance,reference,cryptomatte").size(), aov_catalogue().size());
    for (const char* wrong : {"", "depht", "depth,,ids", "depth,none"}) {
        try {
            parse_aov_groups(wrong);
            ADD_FAILURE() << wrong;
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what())
                          .find("expected albedo, depth, motion, normal, ids, specular, virtual, guides, raw, samples, "
                                "variance, reference, cryptomatte, all or none"),
                      std::string::npos)
                << error.what();
        }
    }
}

}  // namespace

namespace {

// The kernel's locks belong to open files, so two within one process exclude each other as two processes do.
class Locks : public FolderTest {};

TEST_F(Locks, a_file_is_opened_as_it_is_by_one_at_a_time) {
    const auto file = folder / "a";
    put_bytes(file, "earlier");
    const int first = open_locked_file(file);
    ASSERT_GE(first, 0);
    EXPECT_EQ(file_bytes(file), "earlier");
    EXPECT_EQ(open_locked_file(file), -1);
    EXPECT_EQ(errno, EWOULDBLOCK);
    std::filesystem::rename(file, folder / "b");
    const int another = open_locked_file(file);
    EXPECT_GE(another, 0) << "the lock went with the file";
    close(first);
    close(another);
    const int again = open_locked_file(folder / "b");
    EXPECT_GE(again, 0) << "closing unlocks";
    close(again);
}

TEST_F(Locks, missing_files_are_made_or_not) {
    EXPECT_EQ(open_locked_file(folder / "a", IfMissing::fail), -1);
    EXPECT_EQ(errno, ENOENT);
    const int made = open_locked_file(folder / "a");
    EXPECT_GE(made, 0);
    close(made);
    EXPECT_TRUE(std::filesystem::exists(folder / "a"));
}

TEST_F(Locks, a_folder_belongs_to_one_at_a_time) {
    {
        const FolderLock first(folder);
        EXPECT_THROW(FolderLock second(folder), InputError);
    }
    EXPECT_NO_THROW(FolderLock third(folder));
    EXPECT_TRUE(std::filesystem::is_empty(folder)) << "nothing is left behind";
}

TEST_F(Locks, unfinished_files_that_are_being_written_stay) {
    const int writing = open_locked_file(folder / ".frame.0001.exr.aside");
    put_bytes(folder / ".frame.0002.exr.aside", "of a killed run");
    remove_unfinished_files(folder);
    EXPECT_TRUE(std::filesystem::exists(folder / ".frame.0001.exr.aside"));
    EXPECT_FALSE(std::filesystem::exists(folder / ".frame.0002.exr.aside"));
    close(writing);
}

TEST_F(Locks, no_symbolic_link_is_followed_and_no_pipe_waited_for) {
    put_bytes(folder / "victim", "mine");
    std::filesystem::create_symlink(folder / "victim", folder / ".a.json.aside");
    EXPECT_EQ(open_locked_file(folder / ".a.json.aside"), -1);
    try {
        write_file_atomically(folder / "a.json", "{}");
        ADD_FAILURE() << "a symbolic link was followed";
    } catch (const WorkError& error) {
        EXPECT_EQ(error.what(), (folder / "a.json").string() + ": cannot be written: " +
                                    (folder / ".a.json.aside").string() + ", a symbolic link");
    }
    EXPECT_EQ(file_bytes(folder / "victim"), "mine");
    ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
    EXPECT_EQ(open_locked_file(folder / "pipe"), -1);
}

}  // namespace

// A host or a script that asked for its user's locale writes the same frames as any other, and reads them.

namespace {

class Locale : public FolderTest {
protected:
    static Frame frame_of_an_atlas() {
        Frame frame;
        frame.info = test_info(500, 243);
        frame.info.patches = random_atlas(3, 2, 1);
        frame.planes["colour"] = FloatImage(48, 32, 4);
        return frame;
    }
};

TEST_F(Locale, frames_are_the_same_bytes) {
    int number = 0;
    for (const Frame& frame : {test_frame(37, 17), frame_of_an_atlas()}) {
        const auto plain = folder / (std::to_string(++number) + ".exr"), comma = folder / "comma.exr";
        write_exr(plain, frame);
        {
            const CommaLocale locale;
            write_exr(comma, frame);
        }
        EXPECT_TRUE(file_bytes(plain) == file_bytes(comma));
    }
}

TEST_F(Locale, frames_are_read) {
    int number = 0;
    for (const Frame& frame : {test_frame(37, 17), frame_of_an_atlas()}) {
        const auto file = folder / (std::to_string(++number) + ".exr");
        write_exr(file, frame);
        const CommaLocale locale;
        expect_same_info(read_exr(file).info, frame.info);
        expect_same_info(read_exr_info(file), frame.info);
    }
}

TEST_F(Locale, manifests_are_the_same_bytes_and_are_read) {
    Manifest manifest;
    manifest.shared = frame_of_an_atlas().info;
    manifest.planes = {"colour"};
    write_manifest(folder, manifest);
    const std::string plain = file_bytes(folder / "manifest.json");
    const CommaLocale locale;
    write_manifest(folder, manifest);
    EXPECT_EQ(file_bytes(folder / "manifest.json"), plain);
    const FrameInfo back = read_manifest(folder).shared;
    EXPECT_EQ(back.head.orientation, manifest.shared.head.orientation);
    EXPECT_EQ(back.time_s, manifest.shared.time_s);
    EXPECT_EQ(back.ipd_m, manifest.shared.ipd_m);
}

}  // namespace
}  // namespace equistream::testing
