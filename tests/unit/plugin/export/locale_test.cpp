// A host or a script that asked for its user's locale writes the same frames as any other, and reads them.
#include "frame_fixture.h"

#include <tests/comma_locale.h>
#include <tests/unit/atlas_fixture.h>
#include <tests/unit/plugin/stream/frame_info_matcher.h>

namespace equistream::testing {
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
