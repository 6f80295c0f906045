/// What stays of a render that ends early: a host that fails, or is interrupted, at a chosen frame.
#include <host-adapters/common/sequence_renderer.h>

#include <tests/unit/plugin/abi/abi_fixture.h>

#include <equistream/error.h>

#include <nlohmann/json.hpp>

#include <filesystem>
#include <map>
#include <sstream>

namespace equistream::render_command {
namespace {

class ChosenHost : public RenderHost {
public:
    HostText text() const override { return {}; }
    void add_options(cli::CommandLine&) override {}
    const SceneDescription& describe(const RenderOptions&) override { return scene; }
    void load(const RenderOptions&, const Timeline&) override {}
    HostRecord record() const override { return {"chosen host", ""}; }
    void move_to(const FrameTimes& times) override { on_move(times.index); }
    void cast(std::span<const es_ray>, std::span<float>) override {}
    void render(const FrameTask& task) override { on_render(task); }
    HostFigures figures(double, nlohmann::json&) const override { return {}; }

    SceneDescription scene;
    std::function<void(std::int64_t)> on_move = [](std::int64_t) {};
    std::function<void(const FrameTask&)> on_render;
};

class SequenceRendererTest : public testing::AbiTest {
protected:
    void SetUp() override {
        AbiTest::SetUp();
        host_.scene.camera_path = PosePath({{0, {}}}, "test");
        host_.on_render = [](const FrameTask& task) { finish(task); };
    }
    static void finish(const FrameTask& task) { fill(task.frame, miss, black); }

    /// What a render of frames 0 to 4 ends with; empty: all of them.
    std::string end_of_render() { return error_of_render<std::exception>(); }
    /// Other errors are thrown.
    template <typename Error>
    std::string error_of_render() {
        RenderOptions options;
        options.out = output;
        options.size = {32, 16};
        options.spp = 2;
        options.eyes = eyes_;
        options.threads = 1;
        options.aovs = "none";
        options.progress = progress_;
        options.overwrite = overwrite_;
        Timeline timeline;
        timeline.path = host_.scene.camera_path;
        timeline.path_frames = 5;
        timeline.range = {0, 4};
        const std::vector<Stream> streams =
            StreamOpener(options, host_.scene, timeline.path, {host_.record(), 0, "test", {}}).all();
        RenderReport report;
        try {
            SequenceRenderer({options, timeline, 0, streams, interrupted_}, host_, report).run();
        } catch (const Error& error) {
            return error.what();
        }
        return "";
    }
    /// Of one that is refused before its first frame.
    std::string refusal_of_render() {
        try {
            end_of_render();
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    }
    std::vector<std::int64_t> frames() const { return list_frames(output + "/centre"); }
    void remove_frame(std::int64_t index) const {
        std::filesystem::remove(output + "/centre/" + frame_file_name(index));
    }

    ChosenHost host_;
    std::vector<es_eye> eyes_{ES_EYE_CENTRE};
    bool overwrite_ = false;
    cli::ProgressStyle progress_ = cli::ProgressStyle::none;
    std::atomic<bool> interrupted_ = false;
};

using Frames = std::vector<std::int64_t>;

TEST_F(SequenceRendererTest, TheFrameBeforeAFailureIsKept) {
    host_.on_move = [](std::int64_t index) {
        if (index == 3)
            throw WorkError("the host has failed");
    };
    EXPECT_EQ(end_of_render(), "the host has failed");
    EXPECT_EQ(frames(), (Frames{0, 1, 2}));
    host_.on_move = [](std::int64_t) {};
    EXPECT_EQ(end_of_render(), "");
    EXPECT_EQ(frames(), (Frames{0, 1, 2, 3, 4}));
}

/// Whoever runs it may try again: bad usage would say that nothing was done.
TEST_F(SequenceRendererTest, WhatIsRefusedInTheMiddleIsNoBadUsage) {
    host_.on_move = [](std::int64_t index) {
        if (index == 2)
            throw InputError("a part is missing");
    };
    EXPECT_EQ(error_of_render<WorkError>(), "a part is missing");
    EXPECT_EQ(frames(), (Frames{0, 1}));
    std::filesystem::remove_all(output);
    host_.on_move = [](std::int64_t) { throw InputError("a part is missing"); };
    EXPECT_EQ(error_of_render<InputError>(), "a part is missing") << "nothing was done";
}

TEST_F(SequenceRendererTest, AFrameWhoseLastTileWasDoneIsKeptWhenARenderIsInterrupted) {
    host_.on_render = [this](const FrameTask& task) {
        finish(task);
        interrupted_ = task.index == 1;
    };
    EXPECT_EQ(end_of_render(), "interrupted: 2 of 5 frames are finished; run the same command again to continue");
    EXPECT_EQ(frames(), (Frames{0, 1}));
}

TEST_F(SequenceRendererTest, EachEyesFramesAreCounted) {
    eyes_ = {ES_EYE_LEFT, ES_EYE_RIGHT};
    int rendered = 0;
    host_.on_render = [&](const FrameTask& task) {
        finish(task);
        interrupted_ = ++rendered == 3;
    };
    EXPECT_EQ(end_of_render(), "interrupted: 3 of 10 frames are finished; run the same command again to continue");
}

/// Whoever plays the folder would take them for parts of one render.
TEST_F(SequenceRendererTest, FramesOfAnotherRenderBesideItAreRefused) {
    EXPECT_EQ(end_of_render(), "");
    eyes_ = {ES_EYE_LEFT};
    EXPECT_EQ(end_of_render(), "") << "the other eye of the same one";
    overwrite_ = true;
    const auto expected = [this](const std::string& what) {
        return output + "/centre, frame 4: expected the " + what + " of " + output +
               "/left, found another one; render both with one command, remove that folder or choose another --out";
    };
    host_.scene.name = "another";
    EXPECT_EQ(refusal_of_render(), expected("scene"));
    host_.scene.name = "";
    host_.scene.camera_path = PosePath({{0, {{1, 0, 0}, {1, 0, 0, 0}}}}, "test");
    EXPECT_EQ(refusal_of_render(), expected("head position"));
    EXPECT_EQ(read_manifest(output + "/left").shared.head.position_m.x, 0) << "nothing was replaced";
}

/// Players fill gaps of the main view from them, and refuse a folder where they are another eye's.
TEST_F(SequenceRendererTest, LayersOfAnotherEyeThanTheMainViewAreRefused) {
    eyes_ = {ES_EYE_LEFT};
    EXPECT_EQ(end_of_render(), "");
    std::filesystem::copy(output + "/left", output + "/hidden");
    EXPECT_EQ(end_of_render(), "");
    eyes_ = {ES_EYE_RIGHT};
    EXPECT_EQ(end_of_render(), "") << "the left eye is still the main view";
    eyes_ = {ES_EYE_CENTRE};
    EXPECT_EQ(refusal_of_render(),
              output + "/hidden, frame 4: expected the eye of " + output +
                  "/centre, found another one; render both with one command, remove that folder or choose "
                  "another --out");
}

TEST_F(SequenceRendererTest, AnInterruptAfterTheLastTileOfAllIsNoFailure) {
    host_.on_render = [this](const FrameTask& task) {
        finish(task);
        interrupted_ = task.index == 4;
    };
    EXPECT_EQ(end_of_render(), "");
    EXPECT_EQ(frames(), (Frames{0, 1, 2, 3, 4}));
}

TEST_F(SequenceRendererTest, FinishedFramesAreLookedForOnceAndBeforeTheFirst) {
    EXPECT_EQ(end_of_render(), "");
    remove_frame(1);
    Frames rendered;
    host_.on_render = [&](const FrameTask& task) {
        rendered.push_back(task.index);
        remove_frame(3);
        finish(task);
    };
    EXPECT_EQ(end_of_render(), "");
    EXPECT_EQ(rendered, Frames{1});
}

TEST_F(SequenceRendererTest, LookingForFinishedFramesIsTold) {
    EXPECT_EQ(end_of_render(), "");
    remove_frame(1);
    progress_ = cli::ProgressStyle::json;
    ::testing::internal::CaptureStderr();
    EXPECT_EQ(end_of_render(), "");
    std::istringstream told(::testing::internal::GetCapturedStderr());
    std::map<std::string, std::vector<double>> done;
    std::vector<std::string> notes;
    for (std::string line; std::getline(told, line);)
        if (line.starts_with('{')) {
            const auto step = nlohmann::json::parse(line);
            done[step.at("what").get<std::string>()].push_back(step.at("done").get<double>());
            notes.push_back(step.at("note").get<std::string>());
        }
    EXPECT_EQ(done["checking"], std::vector<double>{5}) << "in one line, however many there are";
    EXPECT_EQ(notes.at(0), "4 frames are finished");
    EXPECT_EQ(done["render"].size(), 1u);
}

TEST_F(SequenceRendererTest, AnUnfinishedFrameIsNot) {
    host_.on_render = [this](const FrameTask& task) {
        interrupted_ = task.index == 1;
        if (!interrupted_)
            finish(task);
    };
    EXPECT_EQ(end_of_render(), "interrupted: 1 of 5 frames are finished; run the same command again to continue");
    EXPECT_EQ(frames(), Frames{0});
}

}  // namespace
}  // namespace equistream::render_command
