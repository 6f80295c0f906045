#include "render.h"

#include "frame_job.h"
#include "report.h"
#include "stream.h"

#include <equistream/elapsed.h>
#include <equistream/error.h>

#include <cmath>
#include <csignal>
#include <cstdio>
#include <future>
#include <thread>

namespace equistream::embree_host {
namespace {

std::atomic<bool> interrupted = false;

extern "C" void note_interrupt(int signal) {
    interrupted = true;
    std::signal(signal, SIG_DFL);  // a second one ends the program at once
}

/// The scene as it is traced, and how it moves from frame to frame.
class LoadedScene {
public:
    LoadedScene(const SceneDescription& description, const RenderOptions& options, RenderReport& report)
        : description_(description), model_(load_model(description.model)),
          moving_(find_moving_instances(model_, description)) {
        const auto load_start = Clock::now();
        textures_.emplace(model_);
        shading_.emplace(model_);
        report.load_s += seconds_since(load_start);
        const auto bvh_start = Clock::now();
        bvh_.emplace(model_, BvhOptions{moving_, options.threads, shading_->has_thin_glass()});
        report.bvh_s = seconds_since(bvh_start);
        report.bvh_bytes = bvh_->memory_bytes();
        report.triangles = model_.triangle_count();
        report.unique_triangles = model_.unique_triangle_count();
        if (description.sun)
            lights_.sun.emplace(glm::vec3(description.sun->towards), glm::vec3(description.sun->irradiance),
                                static_cast<float>(description.sun->angular_radius_rad));
        lights_.sky = glm::vec3(description.sky_radiance);
        moves_.assign(model_.instances.size(), 0);
        for (const std::uint32_t instance : moving_)
            moves_[instance] = 1;
        now_ = instance_transforms(model_, description_, 0);
        lights_.emitters.build(*shading_, now_, *textures_);
        traced_.emplace(TracedScene{
            *bvh_, *shading_, *textures_, lights_, {.max_bounces = options.max_bounces, .unbiased = options.unbiased}});
    }

    /// Moves everything to where it is at `time_s`; the neighbours' times are those of motion vectors.
    void move_to(double time_s, double previous_time_s, double next_time_s) {
        if (moving_.empty())
            return;
        now_ = instance_transforms(model_, description_, time_s);
        previous_ = instance_transforms(model_, description_, previous_time_s);
        next_ = instance_transforms(model_, description_, next_time_s);
        bvh_->move(now_);
        shading_->place_instances(now_);
        lights_.emitters.build(*shading_, now_, *textures_);
    }

    const TracedScene& traced() const { return *traced_; }
    NeighbourTransforms neighbours() const { return {previous_, next_, moves_}; }

private:
    const SceneDescription& description_;
    SceneModel model_;
    std::vector<std::uint32_t> moving_;
    std::vector<std::uint8_t> moves_;
    std::vector<glm::mat4> now_, previous_, next_;
    std::optional<Textures> textures_;
    std::optional<ShadingScene> shading_;
    std::optional<Bvh> bvh_;
    Lights lights_;
    std::optional<TracedScene> traced_;
};

/// Which frames there are to make, and at what times.
struct Timeline {
    PosePath path;
    double frames_per_second = 30;
    std::int64_t path_frames = 1;
    cli::FrameRange range;

    double time_s(std::int64_t index) const { return static_cast<double>(index) / frames_per_second; }
};

Timeline make_timeline(const RenderOptions& options, const SceneDescription& scene) {
    Timeline t;
    t.path = options.path.empty() ? scene.camera_path : read_path_csv(options.path);
    if (t.path.empty())
        throw InputError(expected_found(scene.file.string(), "a camera path (or --path)", "none"));
    t.frames_per_second = options.frames_per_second.value_or(scene.frames_per_second);
    // The small term keeps a last key that falls on a frame from being lost to rounding.
    t.path_frames = static_cast<std::int64_t>(std::floor(t.path.duration_s() * t.frames_per_second + 1e-6)) + 1;
    t.range = options.frames.value_or(cli::FrameRange{0, t.path_frames - 1});
    if (t.range.last >= t.path_frames)
        throw InputError(expected_found("--frames", "frames within the path's 0-" + std::to_string(t.path_frames - 1),
                                        std::to_string(t.range.first) + "-" + std::to_string(t.range.last)));
    return t;
}

/// Renders frame after frame; while one is rendered the one before it is written.
class SequenceRenderer {
public:
    SequenceRenderer(const RenderOptions& options, const Timeline& timeline, LoadedScene& scene,
                     const std::vector<Stream>& streams, RenderReport& report)
        : options_(options), timeline_(timeline), scene_(scene), streams_(streams), report_(report),
          progress_("render", static_cast<double>(count_paths()), options.progress) {}

    void run() {
        if (report_.frames_kept > 0)
            std::fprintf(stderr, "equistream render: %lld of %lld frames are finished and kept\n",
                         static_cast<long long>(report_.frames_kept), static_cast<long long>(frames_in_all()));
        const auto start = Clock::now();
        for (std::int64_t index = timeline_.range.first; index <= timeline_.range.last; ++index)
            render_index(index);
        start_writing();
        finish_writing();
        report_.render_s = seconds_since(start);
    }

private:
    std::int64_t frames_in_all() const {
        return (timeline_.range.last - timeline_.range.first + 1) * static_cast<std::int64_t>(streams_.size());
    }

    std::uint64_t count_paths() {
        std::uint64_t paths = 0;
        for (std::int64_t index = timeline_.range.first; index <= timeline_.range.last; ++index)
            for (const Stream& stream : streams_)
                if (es_sequence_has_frame(stream.sequence.get(), index))
                    ++report_.frames_kept;
                else
                    paths += stream.pixels * options_.spp;
        return paths;
    }

    void render_index(std::int64_t index) {
        bool moved = false;
        for (const Stream& stream : streams_) {
            if (es_sequence_has_frame(stream.sequence.get(), index))
                continue;
            if (!std::exchange(moved, true))
                move_scene(index);
            render_frame(stream, index);
        }
    }

    void move_scene(std::int64_t index) {
        const bool first = index == 0, last = index + 1 == timeline_.path_frames;
        scene_.move_to(timeline_.time_s(index), timeline_.time_s(first ? index : index - 1),
                       timeline_.time_s(last ? index : index + 1));
    }

    void render_frame(const Stream& stream, std::int64_t index) {
        // A sequence serves one thread at a time: this frame begins before the last one's writing does.
        FramePointer frame =
            begin_frame(stream, timeline_.path, index, timeline_.path_frames, timeline_.frames_per_second);
        start_writing();
        FrameJob job;
        job.frame = frame.get();
        job.wants_surfaces = stream.wants_surfaces;
        job.scene = &scene_.traced();
        job.neighbours = scene_.neighbours();
        job.threads = report_.threads;
        job.stop = &interrupted;
        job.paths_traced = [this](std::uint64_t paths) { progress_.set(static_cast<double>(paths_ += paths)); };
        report_.counts += run_frame(job);
        finish_writing();
        if (interrupted)
            throw WorkError("interrupted: " + std::to_string(report_.frames_rendered + report_.frames_kept) + " of " +
                            std::to_string(frames_in_all()) + " frames are finished; the same command goes on there");
        rendered_ = std::move(frame);
        note_ = stream.name + " frame " + std::to_string(index);
    }

    void start_writing() {
        if (rendered_)
            writing_ = std::async(std::launch::async, end_frame, std::move(rendered_));
    }

    void finish_writing() {
        if (!writing_)
            return;
        std::exchange(writing_, std::nullopt)->get();
        ++report_.frames_rendered;
        progress_.step(static_cast<double>(paths_), note_);
    }

    const RenderOptions& options_;
    const Timeline& timeline_;
    LoadedScene& scene_;
    const std::vector<Stream>& streams_;
    RenderReport& report_;
    std::atomic<std::uint64_t> paths_ = 0;
    cli::Progress progress_;
    FramePointer rendered_;  // traced, not yet being written
    std::optional<std::future<void>> writing_;
    std::string note_;  // of the frame that is written next
};

}  // namespace

void render(const RenderOptions& options, const std::string& command) {
    if (es_abi_version() != ES_ABI_VERSION)
        throw InputError(expected_found("libequistream", "ABI version " + std::to_string(ES_ABI_VERSION),
                                        std::to_string(es_abi_version())));
    RenderReport report;
    report.threads = options.threads > 0 ? options.threads : std::max(1u, std::thread::hardware_concurrency());
    const auto start = Clock::now();
    const SceneDescription description = load_scene(options.scene);
    const Timeline timeline = make_timeline(options, description);
    LoadedScene scene(description, options, report);
    report.load_s = seconds_since(start) - report.bvh_s;
    const std::vector<Stream> streams = open_streams(options, description, timeline.path, command);
    std::signal(SIGINT, note_interrupt);
    std::signal(SIGTERM, note_interrupt);
    SequenceRenderer(options, timeline, scene, streams, report).run();
    print_report(report, options.json);
}

}  // namespace equistream::embree_host
