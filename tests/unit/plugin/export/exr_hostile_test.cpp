// Damaged files give one clear line that names them; a full disk leaves nothing behind.
#include "frame_fixture.h"

#include <equistream/error.h>
#include <equistream/text.h>
#include <tests/unit/atlas_fixture.h>

#include <csignal>
#include <fcntl.h>
#include <functional>
#include <limits>
#include <random>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>

namespace equistream::testing {
namespace {

class ExrHostile : public FolderTest {
protected:
    /// Reads it whole; a refusal must be an InputError of one line that names the file.
    bool reads(const std::filesystem::path& file) {
        try {
            read_exr(file);
            return true;
        } catch (const InputError& error) {
            const std::string line = error.what();
            EXPECT_NE(line.find(file.string()), std::string::npos) << line;
            EXPECT_EQ(line.find('\n'), std::string::npos) << line;
            return false;
        }
    }
};

TEST_F(ExrHostile, a_pipe_is_not_waited_for) {
    const auto pipe = folder / "pipe.exr";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    EXPECT_FALSE(reads(pipe));
}

TEST_F(ExrHostile, truncated_at_every_step) {
    const auto whole = folder / "whole.exr";
    write_exr(whole, test_frame(48, 40));
    const std::string bytes = file_bytes(whole);
    const auto cut = folder / "cut.exr";
    // Every byte of the headers and tables, then in strides through the pixels, then the last bytes.
    for (std::size_t length = 0; length < bytes.size();
         length += length < 5000 || length + 40 > bytes.size() ? 1 : 97) {
        put_bytes(cut, bytes.substr(0, length));
        ASSERT_FALSE(reads(cut)) << length << " of " << bytes.size() << " bytes";
    }
    put_bytes(cut, bytes);
    EXPECT_TRUE(reads(cut));
}

TEST_F(ExrHostile, flipped_bytes_of_an_atlas_never_crash) {
    Frame frame;
    frame.info = test_info(500, 243);
    frame.info.patches = random_atlas(3, 2, 1);
    frame.planes["colour"] = FloatImage(48, 32, 4);
    const auto whole = folder / "whole.exr", damaged = folder / "damaged.exr";
    write_exr(whole, frame);
    const std::string bytes = file_bytes(whole);
    const std::size_t from = bytes.find("equistream:sphereSize"), to = bytes.find("equistream:pixelCentres");
    ASSERT_LT(from, to);
    std::mt19937 random(17);
    int refused = 0;
    for (int round = 0; round < 2000; ++round) {
        std::string copy = bytes;
        copy[from + random() % (to - from)] = round % 2 == 0 ? static_cast<char>(random()) : "0:-, 99x"[random() % 8];
        put_bytes(damaged, copy);
        refused += reads(damaged) ? 0 : 1;
    }
    EXPECT_GT(refused, 500);
}

TEST_F(ExrHostile, flipped_bytes_never_crash) {
    const auto whole = folder / "whole.exr";
    write_exr(whole, test_frame(32, 33));
    const std::string bytes = file_bytes(whole);
    std::mt19937 random(7);
    const auto damaged = folder / "damaged.exr";
    for (int round = 0; round < 3000; ++round) {
        std::string copy = bytes;
        const std::size_t limit = round % 3 == 0 ? copy.size() : std::min<std::size_t>(copy.size(), 5000);
        for (int i = 0; i < 1 + round % 4; ++i)
            copy[random() % limit] = static_cast<char>(random());
        put_bytes(damaged, copy);
        reads(damaged);
    }
}

TEST_F(ExrHostile, a_small_file_that_claims_a_large_image_allocates_nothing) {
    const auto file = folder / "claims.exr";
    write_exr(file, test_frame(16, 16));
    std::string bytes = file_bytes(file);
    // dataWindow: name, type, length, then min x, min y, max x, max y.
    const std::string tag = std::string("dataWindow") + '\0' + "box2i" + '\0';
    for (std::size_t at = bytes.find(tag); at != std::string::npos; at = bytes.find(tag, at + 1)) {
        const std::int32_t max[2] = {16000, 16000};
        bytes.replace(at + tag.size() + 4 + 8, 8, reinterpret_cast<const char*>(max), 8);
    }
    put_bytes(file, bytes);
    EXPECT_FALSE(reads(file));
}

TEST_F(ExrHostile, poses_and_cameras_beyond_the_limits_are_refused_by_name) {
    const double inf = std::numeric_limits<double>::infinity();
    const auto file = folder / "far.exr";
    const auto refusal = [&](const std::function<void(FrameInfo&)>& change) {
        Frame frame = test_frame(16, 8);
        change(frame.info);
        write_exr(file, frame);
        try {
            read_exr_info(file);
        } catch (const InputError& error) {
            return std::string(error.what());
        }
        return std::string("taken");
    };
    const std::string at = file.string() + ": equistream:", metres = "coordinates from -1e9 to 1e9 metres";
    EXPECT_EQ(refusal([](FrameInfo&) {}), "taken");
    EXPECT_EQ(refusal([](FrameInfo& info) { info.head.position_m.y = -1e9; }), "taken");
    EXPECT_EQ(refusal([](FrameInfo& info) {
                  info.head.position_m = {1e19, 0, 0};
              }),
              at + "headPosition: expected " + metres + ", found 1e+19 0 0");
    EXPECT_EQ(refusal([](FrameInfo& info) {
                  info.camera_pose.position_m = {0, 0, -1.1e9};
              }),
              at + "position: expected " + metres + ", found 0 0 -1.1e+09");
    EXPECT_EQ(refusal([&](FrameInfo& info) {
                  info.head.position_m = {0, inf, 0};
              }),
              at + "headPosition: expected " + metres + ", found 0 inf 0");
    EXPECT_EQ(refusal([](FrameInfo& info) {
                  info.head.orientation = {2, 0, 0, 0};
              }),
              at + "headOrientation: expected a unit quaternion w x y z, found length 2");
    EXPECT_EQ(refusal([](FrameInfo& info) { info.index = -1; }), at + "frame: expected 0 to 999999999, found -1");
    EXPECT_EQ(refusal([](FrameInfo& info) { info.time_s = 1e11; }),
              at + "time: expected a number from -1e+10 to 1e+10, found 1e+11");
    EXPECT_EQ(refusal([](FrameInfo& info) { info.ipd_m = 1e19; }),
              at + "ipd: expected a number from 0 to 10, found 1e+19");
    EXPECT_EQ(refusal([](FrameInfo& info) { info.head_radius_m = 5000; }),
              at + "headBoxRadius: expected a number from 0 to 1000, found 5000");
    EXPECT_EQ(refusal([](FrameInfo& info) {
                  info.camera = EquirectCamera{16, 8, {0, 1e-9, 0, 1}};
              }),
              at + "longitudes: expected an ascending range in radians, 0.001 to " + in_words(2 * pi) +
                  " wide, found 0 to 1e-09");
    EXPECT_EQ(refusal([](FrameInfo& info) {
                  info.camera = EquirectCamera{16, 8, {0, 1, 0, 2}};
              }),
              at + "latitudes: expected latitudes from -pi/2 to pi/2, found 0 to 2");
    EXPECT_EQ(refusal([](FrameInfo& info) {
                  info.camera = PerspectiveCamera{16, 8, 1e-5};
              }),
              at + "fovX: expected radians from 0.001 to pi - 0.001, found 1e-05");
}

TEST_F(ExrHostile, quaternions_are_four_numbers) {
    const auto file = folder / "turned.exr";
    Frame frame = test_frame(16, 8);
    frame.info.camera_pose.orientation = {0, -1, 0, 0};
    write_exr(file, frame);
    const std::string bytes = file_bytes(file), written = "0 -1 0 0";
    const std::size_t begin = bytes.find(written);
    ASSERT_NE(begin, std::string::npos);
    for (const std::string wrong :
         {"0,-1,0,0", "0 -1 0 ,", "0 -1 0  ", "0 -1 0 x", " 0 -1 0 ", "0 -1 0.0", "nan -1 0"}) {
        std::string copy = bytes;
        put_bytes(file, copy.replace(begin, written.size(), wrong));
        EXPECT_FALSE(reads(file)) << wrong;
    }
    put_bytes(file, bytes);
    EXPECT_TRUE(reads(file));
}

TEST_F(ExrHostile, not_an_exr_at_all) {
    put_bytes(folder / "text.exr", "not an EXR");
    EXPECT_FALSE(reads(folder / "text.exr"));
    EXPECT_FALSE(reads(folder / "missing.exr"));
    EXPECT_FALSE(reads(folder));
    put_bytes(folder / "empty.exr", "");
    EXPECT_FALSE(reads(folder / "empty.exr"));
}

/// Stands for a full disk: no file may grow beyond `bytes` while this lives.
class FileSizeLimit {
public:
    explicit FileSizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
        getrlimit(RLIMIT_FSIZE, &before_);
        const rlimit limited{bytes, before_.rlim_max};
        setrlimit(RLIMIT_FSIZE, &limited);
    }
    ~FileSizeLimit() {
        setrlimit(RLIMIT_FSIZE, &before_);
        std::signal(SIGXFSZ, handler_);
    }

private:
    rlimit before_{};
    void (*handler_)(int);
};

TEST_F(ExrHostile, a_full_disk_is_a_work_error_and_loses_nothing) {
    const auto file = folder / "frame.0000.exr";
    write_exr(file, test_frame(64, 64));
    const std::string before = file_bytes(file);
    for (const rlim_t limit : {10, 600, 5000, 20000}) {
        const FileSizeLimit full(limit);
        Frame other = test_frame(64, 64);
        other.info.index = 42;
        try {
            write_exr(file, other);
            FAIL() << "expected a WorkError";
        } catch (const WorkError& error) {
            EXPECT_NE(std::string(error.what()).find(file.string() + ": cannot be written: File too large"),
                      std::string::npos)
                << error.what();
        }
    }
    EXPECT_EQ(file_bytes(file), before);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
}

TEST_F(ExrHostile, what_a_killed_run_left_is_taken_over) {
    put_bytes(folder / ".frame.0003.exr.aside", std::string(100000, 'x'));
    EXPECT_TRUE(list_frames(folder).empty());
    write_exr(folder / "frame.0003.exr", test_frame(16, 16));
    EXPECT_TRUE(reads(folder / "frame.0003.exr"));
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
}

TEST_F(ExrHostile, two_writers_of_one_file_do_not_mix) {
    const auto aside = folder / ".frame.0003.exr.aside";
    const int other = open(aside.c_str(), O_CREAT | O_WRONLY, 0666);
    ASSERT_EQ(flock(other, LOCK_EX), 0);
    EXPECT_THROW(write_exr(folder / "frame.0003.exr", test_frame(4, 4)), WorkError);
    close(other);
    write_exr(folder / "frame.0003.exr", test_frame(4, 4));
    EXPECT_EQ(list_frames(folder), std::vector<std::int64_t>{3});
}

}  // namespace
}  // namespace equistream::testing
