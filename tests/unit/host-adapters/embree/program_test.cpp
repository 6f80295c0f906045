/// The program, run as a user runs it: same pixels on any number of threads, resuming, streams, windows, bad usage,
/// interrupts.
#include <equistream/locks.h>
#include <equistream/sequence.h>

#include <scenes/generate/generate.h>

#include <gtest/gtest.h>

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <thread>

namespace equistream {
namespace {

namespace fs = std::filesystem;

class RenderProgram : public testing::Test {
protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() / ("equistream-render-test-" + std::to_string(getpid()));
        fs::create_directories(folder_);
        scene_ = write_scene(make_scene(find_generator("motion")), folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }

    struct Outcome {
        int exit_code = -1;
        std::string standard_output, error;
    };

    std::string command(const std::string& arguments) const {
        return std::string(EQUISTREAM_RENDER) + " " + scene_.string() + " " + arguments;
    }
    Outcome run(const std::string& arguments) const { return run_line(command("--size 32x16 --spp 4 " + arguments)); }

    Outcome run_line(const std::string& line) const {
        const fs::path out = folder_ / "stdout.txt", err = folder_ / "stderr.txt";
        const int status = std::system((line + " >" + out.string() + " 2>" + err.string()).c_str());
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(out), text_of(err)};
    }

    static std::string text_of(const fs::path& file) {
        std::ostringstream text;
        text << std::ifstream(file).rdbuf();
        return text.str();
    }

    void expect_same_planes(const fs::path& a, const fs::path& b) const {
        const Frame one = read_exr(folder_ / a), other = read_exr(folder_ / b);
        ASSERT_EQ(one.planes.size(), other.planes.size());
        for (const auto& [name, plane] : one.planes)
            EXPECT_TRUE(std::ranges::equal(plane.samples(), other.planes.at(name).samples())) << name;
        for (const auto& [name, plane] : one.ids)
            EXPECT_TRUE(std::ranges::equal(plane.samples(), other.ids.at(name).samples())) << name;
    }

    std::string out(const char* name) const { return "--out " + (folder_ / name).string(); }

    fs::path folder_, scene_;
};

TEST_F(RenderProgram, PixelsDoNotDependOnThreads) {
    ASSERT_EQ(run("--frames 1-2 --threads 1 " + out("one")).exit_code, 0);
    ASSERT_EQ(run("--frames 1-2 --threads 5 " + out("five")).exit_code, 0);
    expect_same_planes("one/centre/frame.0001.exr", "five/centre/frame.0001.exr");
    expect_same_planes("one/centre/frame.0002.exr", "five/centre/frame.0002.exr");
}

TEST_F(RenderProgram, OtherSeedsChangeColourAndNothingElse) {
    ASSERT_EQ(run("--frames 0 --seed 1 " + out("a")).exit_code, 0);
    ASSERT_EQ(run("--frames 0 --seed 2 " + out("b")).exit_code, 0);
    const Frame a = read_exr(folder_ / "a/centre/frame.0000.exr"), b = read_exr(folder_ / "b/centre/frame.0000.exr");
    EXPECT_FALSE(std::ranges::equal(a.planes.at("colour").samples(), b.planes.at("colour").samples()));
    for (const char* plane : {"depth", "forward", "backward", "normal", "albedo"})
        EXPECT_TRUE(std::ranges::equal(a.planes.at(plane).samples(), b.planes.at(plane).samples())) << plane;
}

TEST_F(RenderProgram, UnbiasedReachesTheTracerAndIsNotMixedWithTheDefault) {
    scene_ = write_scene(make_scene(find_generator("furnace")), folder_);
    ASSERT_EQ(run("--frames 0 " + out("default")).exit_code, 0);
    ASSERT_EQ(run("--frames 0 --unbiased " + out("unbiased")).exit_code, 0);
    const Frame a = read_exr(folder_ / "default/centre/frame.0000.exr");
    const Frame b = read_exr(folder_ / "unbiased/centre/frame.0000.exr");
    EXPECT_FALSE(std::ranges::equal(a.planes.at("colour").samples(), b.planes.at("colour").samples()));
    EXPECT_TRUE(std::ranges::equal(a.planes.at("albedo").samples(), b.planes.at("albedo").samples()));
    const Outcome mixed = run("--frames 0 --unbiased " + out("default"));
    EXPECT_EQ(mixed.exit_code, 2);
    EXPECT_NE(mixed.error.find("fingerprint"), std::string::npos) << mixed.error;
}

TEST_F(RenderProgram, TheHiddenLayerIsAStreamLikeOthers) {
    ASSERT_EQ(run("--frames 2 " + out("layers")).exit_code, 0);
    const Outcome added = run("--frames 2-3 --layers --threads 1 " + out("layers"));
    ASSERT_EQ(added.exit_code, 0) << added.error;
    EXPECT_NE(added.error.find("1 of 4 frames are finished and kept"), std::string::npos) << added.error;
    ASSERT_EQ(run("--frames 3 --layers --threads 5 " + out("again")).exit_code, 0);
    const Frame frame = read_exr(folder_ / "layers/hidden/frame.0003.exr");
    const Frame again = read_exr(folder_ / "again/hidden/frame.0003.exr");
    EXPECT_EQ(frame.planes.size(), 2u) << "colour and depth";
    const auto &colour = frame.planes.at("colour"), &depth = frame.planes.at("depth");
    EXPECT_TRUE(std::ranges::equal(colour.samples(), again.planes.at("colour").samples()));
    int there = 0;
    for (std::size_t i = 0; i < depth.samples().size(); ++i) {
        const float z = depth.samples()[i], other = again.planes.at("depth").samples()[i];
        EXPECT_TRUE(z == other || (std::isnan(z) && std::isnan(other)));
        there += !std::isnan(z);
        if (std::isnan(z)) {
            EXPECT_EQ(colour.samples()[4 * i + 3], 0);
        }
    }
    EXPECT_GT(there, 0);
    EXPECT_LT(there, 256);
    const Outcome both = run("--frames 2 --eye both --layers " + out("both"));
    EXPECT_EQ(both.exit_code, 2);
    EXPECT_EQ(both.error, "equistream render: --layers: expected one --eye, whose hidden layer goes into DIR/hidden, "
                          "found --eye both\n");
}

/// A denoiser looks across the window's border: what was not traced there must not be black.
TEST_F(RenderProgram, TheBasesGuidesGoOnUnderTheWindow) {
    const std::string small = "--spp 2 --frames 2 --size 96x48 --aovs guides ";
    ASSERT_EQ(run_line(command(small + out("plain"))).exit_code, 0);
    ASSERT_EQ(run_line(command(small + "--window 165,5,90x90 --density 384 " + out("windowed"))).exit_code, 0);
    const Frame plain = read_exr(folder_ / "plain/centre/frame.0002.exr");
    const Frame base = read_exr(folder_ / "windowed/centre/frame.0002.exr");
    for (const char* name : {"guide_albedo", "guide_normal"})
        for (int y = 0; y < 48; ++y)
            for (int x = 0; x < 96; ++x) {
                const float *found = base.planes.at(name).pixel(x, y), *traced = plain.planes.at(name).pixel(x, y);
                const bool is_covered = x >= 80 && y >= 16 && y < 32;  // the one tile within the window
                if (is_covered) {
                    ASSERT_NE(glm::vec3(found[0], found[1], found[2]), glm::vec3(0)) << name << ' ' << x << ", " << y;
                }
                for (int c = 0; c < 3 && !is_covered; ++c)
                    ASSERT_EQ(found[c], traced[c]) << name << ' ' << x << ", " << y;
            }
}

TEST_F(RenderProgram, AWindowIsPartOfADenserSphereAndTheBaseShowsIt) {
    const std::string small = "--spp 2 --frames 1-2 --size 96x48 --density 384 --aovs depth,normal ";
    const auto run_window = [&](const std::string& more) { return run_line(command(small + more)); };
    const Outcome whole = run_window("--window 165,5,90x90 --threads 1 --json " + out("whole"));  // over the seam
    ASSERT_EQ(whole.exit_code, 0) << whole.error;
    EXPECT_NE(whole.standard_output.find("\"columns\": 384"), std::string::npos) << whole.standard_output;
    const std::uint64_t pixels = 96 * 96 + 96 * 48 - 16 * 16;  // one tile of the base lies within
    EXPECT_NE(whole.standard_output.find("\"paths\": " + std::to_string(2 * 2 * pixels)), std::string::npos)
        << whole.standard_output;
    ASSERT_EQ(run_line(command("--spp 2 --frames 2 --size 384x192 --aovs depth,normal " + out("dense"))).exit_code, 0);
    const Frame window = read_exr(folder_ / "whole/window/frame.0002.exr");
    const Frame dense = read_exr(folder_ / "dense/centre/frame.0002.exr");
    const WindowPlace place{320, 48};
    EXPECT_EQ(window_place(window_grid_of(window.info), std::get<EquirectCamera>(window.info.camera).range), place);
    ASSERT_EQ(window.planes.size(), 3u);
    for (const auto& [name, part] : window.planes)
        for (int y = 0; y < 96; ++y)
            for (int x = 0; x < 96; ++x)
                for (int c = 0; c < part.channels(); ++c)
                    ASSERT_EQ(part.pixel(x, y)[c], dense.planes.at(name).pixel((place.x + x) % 384, place.y + y)[c])
                        << name << ' ' << x << ", " << y;
    // Interrupted between a window and its base, and resumed: nothing differs.
    fs::copy(folder_ / "whole", folder_ / "resumed", fs::copy_options::recursive);
    fs::remove(folder_ / "resumed/centre/frame.0001.exr");
    fs::remove(folder_ / "resumed/centre/frame.0002.exr");
    fs::remove(folder_ / "resumed/window/frame.0002.exr");
    ASSERT_EQ(run_window("--window 165,5,90x90 --threads 3 " + out("resumed")).exit_code, 0);
    for (const char* frame : {"frame.0001.exr", "frame.0002.exr"})
        for (const char* stream : {"window", "centre"})
            expect_same_planes(fs::path("whole") / stream / frame, fs::path("resumed") / stream / frame);
    const Outcome moved = run_window("--window 0,5,90x90 " + out("whole"));
    EXPECT_EQ(moved.exit_code, 2);
    EXPECT_NE(moved.error.find("fingerprint"), std::string::npos) << moved.error;
    EXPECT_EQ(run_window("--window gaze,90x90 --lock path --small right " + out("gaze")).exit_code, 0);
    EXPECT_EQ(
        window_place(window_grid_of(window.info),
                     std::get<EquirectCamera>(read_exr_info(folder_ / "gaze/window/frame.0001.exr").camera).range),
        (WindowPlace{144, 48}))
        << "straight ahead of a sphere that turns with the path";
}

TEST_F(RenderProgram, PatchesAreAStreamLikeOthersAndGoOnWithTheirSlots) {
    const std::string few = "--size 128x64 --patches --patch-side 8 --lock path ";
    const auto run_few = [&](const std::string& more) { return run_line(command("--spp 2 " + few + more)); };
    const Outcome whole = run_few("--frames 0-2 --json " + out("whole"));
    ASSERT_EQ(whole.exit_code, 0) << whole.error;
    EXPECT_NE(whole.standard_output.find("\"covered_of_training\""), std::string::npos) << whole.standard_output;
    const Frame frame = read_exr(folder_ / "whole/patches/frame.0001.exr");
    ASSERT_TRUE(frame.info.patches);
    EXPECT_EQ(frame.info.patches->sphere_width, 128);
    EXPECT_LE(frame.info.patches->columns * frame.info.patches->rows, 12) << "a tenth of the sphere's pixels";
    EXPECT_GT(frame.info.patches->used_slots(), 0u);
    EXPECT_EQ(frame.planes.size(), 2u) << "colour and depth";
    // Interrupted after frame 1, resumed by another number of threads: nothing differs.
    ASSERT_EQ(run_few("--frames 0-1 " + out("resumed")).exit_code, 0);
    const Outcome resumed = run_few("--frames 0-2 --threads 1 " + out("resumed"));
    ASSERT_EQ(resumed.exit_code, 0) << resumed.error;
    EXPECT_NE(resumed.error.find("4 of 6 frames are finished and kept"), std::string::npos) << resumed.error;
    const Frame a = read_exr(folder_ / "whole/patches/frame.0002.exr");
    const Frame b = read_exr(folder_ / "resumed/patches/frame.0002.exr");
    EXPECT_EQ(a.info.patches->slots, b.info.patches->slots);
    EXPECT_TRUE(std::ranges::equal(a.planes.at("colour").samples(), b.planes.at("colour").samples()));
    // A frame before that was cut is as good as none.
    fs::resize_file(folder_ / "resumed/patches/frame.0001.exr", 100);
    fs::remove(folder_ / "resumed/centre/frame.0002.exr");
    fs::remove(folder_ / "resumed/patches/frame.0002.exr");
    const Outcome cut = run_few("--frames 2 " + out("resumed"));
    EXPECT_EQ(cut.exit_code, 0) << cut.error;
    EXPECT_TRUE(fs::exists(folder_ / "resumed/patches/frame.0002.exr"));

    const auto refused = [&](const std::string& more) { return run_line(command(more + out("refused"))).error; };
    EXPECT_EQ(
        refused("--patches --eye both "),
        "equistream render: --patches: expected one sphere, whose patches go into DIR/patches, found --eye both\n");
    EXPECT_EQ(refused("--patches --camera perspective "), "equistream render: --patches: expected one sphere, whose "
                                                          "patches go into DIR/patches, found --camera perspective\n");
    EXPECT_EQ(refused("--patch-budget 5 "),
              "equistream render: --patch-budget: expected --patches as well, found none\n");
    EXPECT_NE(refused("--patches --patch-side 8 --size 32x16 ").find("at least one patch"), std::string::npos);
    EXPECT_NE(run_few("--frames 0 --patch-budget 5 " + out("whole")).error.find("expected patches {"),
              std::string::npos);
}

TEST_F(RenderProgram, WritesEveryStreamAskedFor) {
    const Outcome outcome = run("--frames 3 --eye both --small right --json " + out("all"));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.error;
    EXPECT_NE(outcome.standard_output.find("\"frames_rendered\": 3"), std::string::npos) << outcome.standard_output;
    for (const char* eye : {"left", "right"}) {
        const Frame frame = read_exr(folder_ / "all" / eye / "frame.0003.exr");
        EXPECT_EQ(width_of(frame.info.camera), 32);
        EXPECT_EQ(frame.info.eye, std::string(eye) == "left" ? Eye::left : Eye::right);
        EXPECT_TRUE(frame.planes.contains("depth"));
        EXPECT_TRUE(frame.ids.contains("object_id"));
    }
    const Frame small = read_exr(folder_ / "all/small/frame.0003.exr");
    EXPECT_EQ(width_of(small.info.camera), 8);
    EXPECT_EQ(height_of(small.info.camera), 4);
    EXPECT_EQ(small.info.eye, Eye::right);
    EXPECT_FALSE(small.planes.contains("depth"));
    const std::string note = "note: --small has ";
    EXPECT_NE(outcome.error.find(note + "8x4 pixels; encode needs sides of at least 64"), std::string::npos)
        << outcome.error;
    const Outcome enough = run_line(command("--size 512x256 --spp 1 --frames 0 --small right " + out("enough")));
    EXPECT_EQ(enough.error.find(note), std::string::npos) << enough.error;
}

TEST_F(RenderProgram, ResumesWhereItStopped) {
    ASSERT_EQ(run("--frames 0-2 " + out("whole")).exit_code, 0);
    ASSERT_EQ(run("--frames 0-2 " + out("broken")).exit_code, 0);
    const fs::path kept = folder_ / "broken/centre/frame.0000.exr";
    const auto written = fs::last_write_time(kept);
    fs::remove(folder_ / "broken/centre/frame.0001.exr");
    const Outcome again = run("--frames 0-2 " + out("broken"));
    EXPECT_EQ(again.exit_code, 0) << again.error;
    EXPECT_NE(again.error.find("2 of 3 frames are finished and kept"), std::string::npos) << again.error;
    EXPECT_EQ(fs::last_write_time(kept), written);
    expect_same_planes("whole/centre/frame.0001.exr", "broken/centre/frame.0001.exr");

    const Outcome other = run("--frames 0-2 --seed 9 " + out("broken"));
    EXPECT_EQ(other.exit_code, 2);
    EXPECT_EQ(run("--frames 0-2 --seed 9 --overwrite " + out("broken")).exit_code, 0);
}

TEST_F(RenderProgram, FramesOfOtherCodeAreNotAddedTo) {
    ASSERT_EQ(run("--frames 0 --aovs none " + out("old")).exit_code, 0);
    Manifest manifest = read_manifest(folder_ / "old/centre");
    const std::string name = manifest.shared.host;
    const std::string mark = ", code ";
    ASSERT_EQ(name.rfind(mark), name.size() - mark.size() - 8) << name;
    const std::string digits = name.substr(name.size() - 8);
    EXPECT_EQ(digits.find_first_not_of("0123456789abcdef"), std::string::npos) << name;
    EXPECT_EQ(read_exr_info(folder_ / "old/centre/frame.0000.exr").host, name);

    manifest.shared.host.replace(name.size() - 8, 8, digits == "00000000" ? "11111111" : "00000000");
    write_manifest(folder_ / "old/centre", manifest);
    const Outcome resumed = run("--frames 0-1 --aovs none " + out("old"));
    EXPECT_EQ(resumed.exit_code, 2);
    EXPECT_NE(resumed.error.find("or its code has changed"), std::string::npos) << resumed.error;
    EXPECT_FALSE(fs::exists(folder_ / "old/centre/frame.0001.exr"));
}

TEST_F(RenderProgram, TwoRendersDoNotShareAFolder) {
    ASSERT_EQ(run("--frames 0 --aovs none " + out("shared")).exit_code, 0);
    {
        const FolderLock of_another_render(folder_ / "shared/centre");
        for (const char* settings : {"--seed 9 --overwrite ", ""}) {
            const Outcome second = run("--frames 0-1 --aovs none " + std::string(settings) + out("shared"));
            EXPECT_EQ(second.exit_code, 2);
            EXPECT_EQ(std::ranges::count(second.error, '\n'), 1) << second.error;
            EXPECT_NE(second.error.find((folder_ / "shared/centre").string() + ": expected a folder that no other "
                                                                               "process is writing to"),
                      std::string::npos)
                << second.error;
        }
    }
    EXPECT_FALSE(fs::exists(folder_ / "shared/centre/frame.0001.exr"));
    EXPECT_EQ(run("--frames 0-1 --aovs none " + out("shared")).exit_code, 0);
    EXPECT_EQ(run("--frames 0 --eye both --small right --aovs none " + out("eyes")).exit_code, 0)
        << "one process holds the folders of all its views";
}

TEST_F(RenderProgram, AnInterruptLeavesWholeFramesOnly) {
    const pid_t child = fork();
    if (child == 0) {
        const std::string line = "exec " + command("--spp 60 --size 128x64 --threads 2 " + out("cut")) +
                                 " >/dev/null 2>" + (folder_ / "cut.txt").string();
        execl("/bin/sh", "sh", "-c", line.c_str(), nullptr);
        _exit(127);
    }
    // Wait until a frame is there, so that the second is under way.
    for (int i = 0; i < 600 && !fs::exists(folder_ / "cut/centre/frame.0000.exr"); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    kill(child, SIGINT);
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status)) << "so that a shell's loop ends too";
    EXPECT_EQ(WTERMSIG(status), SIGINT);
    EXPECT_NE(text_of(folder_ / "cut.txt").find("interrupted"), std::string::npos) << text_of(folder_ / "cut.txt");
    for (const auto& entry : fs::directory_iterator(folder_ / "cut/centre")) {
        const std::string name = entry.path().filename().string();
        if (name == "manifest.json")
            continue;
        EXPECT_NO_THROW(read_exr(entry.path())) << name;
    }
}

TEST_F(RenderProgram, APathInEpochSecondsBeginsAtItsFirstSample) {
    const auto path = [this](const char* name, const std::string& first, const std::string& last) {
        std::ofstream(folder_ / name) << first << ",1,0,0,1,0,0,0\n" << last << ",2,0,0,1,0,0,0\n";
        return "--aovs none --path " + (folder_ / name).string() + " ";
    };
    const Outcome epoch = run(path("epoch.csv", "1763958000", "1763958000.1") + out("epoch"));
    ASSERT_EQ(epoch.exit_code, 0) << epoch.error;
    EXPECT_NE(epoch.error.find("note: " + (folder_ / "epoch.csv").string() + " begins at 1763958000 s; its times"),
              std::string::npos)
        << epoch.error;
    EXPECT_EQ(list_frames(folder_ / "epoch/centre").size(), 4u);
    EXPECT_EQ(read_exr_info(folder_ / "epoch/centre/frame.0003.exr").head.position_m.x, 2);
    const Outcome ns = run(path("ns.csv", "1763958000000000000", "1763958000100000000") + out("ns"));
    EXPECT_EQ(ns.exit_code, 2);
    EXPECT_NE(ns.error.find("ns.csv: expected times in seconds"), std::string::npos) << ns.error;
}

TEST_F(RenderProgram, AnExposureAtWhichFramesCannotHoldWhiteIsNoted) {
    const auto noted = [this](double exposure) {
        GeneratedScene scene = make_scene(find_generator("furnace"));
        scene.description.exposure = exposure;
        scene_ = write_scene(scene, folder_);
        const Outcome planned = run("--dry-run " + out("none"));
        EXPECT_EQ(planned.exit_code, 0) << planned.error;
        return planned.error;
    };
    EXPECT_EQ(noted(1.6e-5), "");
    const std::string dark = noted(1e-6);
    EXPECT_EQ(dark, "equistream render: note: " + scene_.string() +
                        ": exposure 1e-06 shows radiance 1e+06 as white, but frames hold at most 65504: what is "
                        "brighter than 0.066 of white is cut. Divide all lights by a factor, and multiply exposure by "
                        "it\n");
}

TEST_F(RenderProgram, ACameraFarFromTheOriginIsNoted) {
    const auto noted = [this](const std::string& x_m) {
        std::ofstream(folder_ / "far.csv") << "0,0,0,0,1,0,0,0\n1," << x_m << ",0,0,1,0,0,0\n";
        const Outcome planned = run("--dry-run --path " + (folder_ / "far.csv").string() + " " + out("none"));
        EXPECT_EQ(planned.exit_code, 0) << planned.error;
        return planned.error;
    };
    EXPECT_EQ(noted("2000"), "");
    EXPECT_EQ(noted("-500000"), "equistream render: note: " + scene_.string() +
                                    ": the camera goes 500000 m from the world's origin: places are rounded to 0.031 m "
                                    "there, and light may leak through walls. Move the model and all paths to within "
                                    "2000 m of the origin\n");
}

TEST_F(RenderProgram, ALongPathCanBeInterruptedBeforeItsFirstFrame) {
    std::ofstream(folder_ / "day.csv") << "0,0,0,0,1,0,0,0\n86400,1,0,0,1,0,0,0\n";
    const pid_t child = fork();
    if (child == 0) {
        const std::string line =
            "exec " +
            command("--spp 1 --size 32x16 --fps 1000 --path " + (folder_ / "day.csv").string() + " " + out("day")) +
            " >/dev/null 2>" + (folder_ / "day.txt").string();
        execl("/bin/sh", "sh", "-c", line.c_str(), nullptr);
        _exit(127);
    }
    for (int i = 0; i < 600 && !fs::exists(folder_ / "day/centre"); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    std::this_thread::sleep_for(std::chrono::seconds(2));
    kill(child, SIGTERM);
    int status = 0;
    pid_t ended = 0;
    for (int i = 0; i < 100 && ended == 0; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        ended = waitpid(child, &status, WNOHANG);
    }
    if (ended == 0) {
        kill(child, SIGKILL);
        waitpid(child, &status, 0);
    }
    ASSERT_TRUE(WIFEXITED(status)) << "10 seconds after SIGTERM";
    EXPECT_EQ(WEXITSTATUS(status), 1);
    EXPECT_NE(text_of(folder_ / "day.txt").find("interrupted: 0 of 86400001 frames"), std::string::npos)
        << text_of(folder_ / "day.txt");
}

TEST_F(RenderProgram, BadUsageIsOneLineAndExitTwo) {
    for (const char* bad :
         {"--frames 5-3", "--frames 0-99999", "--frames x", "--size 0x4", "--spp 0", "--eye top", "--host mitsuba",
          "--camera perspective --range 90,90", "--fov 60", "--range 400,10", "--range 90", "--aovs dept",
          "--small right --size 33x16", "--path nowhere.csv", "--no-such-option"}) {
        const Outcome outcome = run_line(command(std::string(bad) + " " + out("never")));
        EXPECT_EQ(outcome.exit_code, 2) << bad << ": " << outcome.error;
        EXPECT_EQ(std::ranges::count(outcome.error, '\n'), 1) << bad << ": " << outcome.error;
        EXPECT_FALSE(fs::exists(folder_ / "never/centre/manifest.json")) << bad;
    }
    const Outcome missing = run_line(std::string(EQUISTREAM_RENDER) + " nowhere.json " + out("never"));
    EXPECT_EQ(missing.exit_code, 2);
    EXPECT_NE(missing.error.find("nowhere.json"), std::string::npos);
    const Outcome nameless = run("--frames 0 --aovs none --out ''");
    EXPECT_EQ(nameless.exit_code, 2);
    EXPECT_NE(nameless.error.find("--out: expected the name of a folder, found ''"), std::string::npos)
        << nameless.error;
    const Outcome unwritable = run("--frames 0 --out /proc/equistream");
    EXPECT_EQ(unwritable.exit_code, 2) << unwritable.error;
}

TEST_F(RenderProgram, PerspectiveTakesFieldOfView) {
    ASSERT_EQ(run("--frames 0 --camera perspective --fov 60 --aovs depth " + out("view")).exit_code, 0);
    const FrameInfo info = read_exr_info(folder_ / "view/centre/frame.0000.exr");
    ASSERT_TRUE(std::holds_alternative<PerspectiveCamera>(info.camera));
    EXPECT_NEAR(std::get<PerspectiveCamera>(info.camera).fov_x_rad, pi / 3, 1e-6);
}

}  // namespace
}  // namespace equistream
