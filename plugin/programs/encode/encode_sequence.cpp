#include "encode_sequence.h"

#include <equistream/colour.h>
#include <equistream/elapsed.h>
#include <equistream/error.h>
#include <equistream/formatted.h>
#include <equistream/sequence.h>

#include <algorithm>
#include <cmath>
#include <future>

namespace equistream {

namespace {

/// One frame of one track, ready to be coded.
struct Picture {
    TrackRole role = TrackRole::main;
    FrameInfo info;
    ByteImage rgb;
    /// Of the tracks that go with its own, in their order.
    std::vector<std::pair<const DepthTrack*, FloatImage>> distances_m;
    std::int64_t not_finite_samples = 0;
    double read_ms = 0;
    double display_ms = 0;
};

/// Depth of a colour track, and what its mirrors show, where the plan has them.
std::vector<const DepthTrack*> distances_of(const DepthPlan& plan, TrackRole colour) {
    std::vector<const DepthTrack*> tracks;
    for (const DepthTrack& track : plan.tracks)
        if (track.source.role == colour)
            tracks.push_back(&track);
    return tracks;
}

Picture read_picture(const SourceTrack& track, std::int64_t index, const DepthPlan& plan,
                     const DisplayTransform& display) {
    Picture picture;
    picture.role = track.role;
    const auto file = track.folder / frame_file_name(index);
    auto start = Clock::now();
    std::vector<std::string> planes = {"colour"};
    for (const DepthTrack* distances : distances_of(plan, track.role))
        for (std::string& plane : planes_of(distances->role))
            planes.push_back(std::move(plane));
    Frame frame = read_exr(file, planes);
    picture.read_ms = milliseconds_since(start);
    const auto colour = frame.planes.find("colour");
    if (colour == frame.planes.end())
        throw InputError(expected_found(file.string(), "channels R, G and B", "none"));
    for (const DepthTrack* distances : distances_of(plan, track.role))
        picture.distances_m.emplace_back(distances, distances_to_code(*distances, frame, file));
    picture.info = frame.info;
    picture.info.index = index;  // a foreign file has its number in its name only
    start = Clock::now();
    picture.not_finite_samples = std::count_if(colour->second.samples().begin(), colour->second.samples().end(),
                                               [](float value) { return !std::isfinite(value); });
    picture.rgb = quantise_8bit(display.to_display(colour->second.view(), frame.info.exposure).view());
    picture.display_ms = milliseconds_since(start);
    return picture;
}

std::vector<Picture> read_frame(const Sources& sources, const DepthPlan& plan, std::int64_t index,
                                const DisplayTransform& display) {
    std::vector<Picture> pictures;
    for (const SourceTrack& track : sources.tracks)
        pictures.push_back(read_picture(track, index, plan, display));
    return pictures;
}

StreamSettings settings_for(const EncodeRequest& request, const std::vector<Picture>& first) {
    StreamSettings settings = request.settings;
    settings.tracks.clear();
    for (const Picture& picture : first) {
        settings.tracks.push_back({picture.role, picture.rgb.width(), picture.rgb.height()});
        if (picture.role != TrackRole::main)
            settings.tracks.back().crf =
                request.fill_crf.value_or(default_fill_crf(picture.role, request.settings.crf));
        for (const auto& [track, distances_m] : picture.distances_m)
            settings.tracks.push_back(
                {track->role, distances_m.width(), distances_m.height(), track->code, track->crf, track->halved});
    }
    settings.frames_per_second = first.front().info.frames_per_second;
    settings.scene = first.front().info.scene;
    const auto* sphere = std::get_if<EquirectCamera>(&first.front().info.camera);
    settings.full_sphere = sphere != nullptr && sphere->range.is_full_sphere();
    settings.pictures = static_cast<std::uint32_t>(request.sources.frames.size());
    return settings;
}

/// What can be seen before the first picture is coded, with the folder's name in front.
void check_sizes(const std::vector<Picture>& first, const Sources& sources) {
    for (std::size_t i = 0; i < first.size(); ++i) {
        const int width = first[i].rgb.width(), height = first[i].rgb.height();
        if (width % 2 != 0 || height % 2 != 0)
            throw InputError(expected_found(sources.tracks[i].folder.string(),
                                            "frames of even width and height (4:2:0 video has no odd sizes)",
                                            size_text(width, height)));
    }
}

/// A track is of one render, with one size throughout.
void check_one_render(const std::vector<Picture>& pictures, const Sources& sources, std::vector<OneRender>& renders) {
    for (std::size_t i = 0; i < pictures.size(); ++i)
        renders[i].require(sources.tracks[i].folder / frame_file_name(pictures[i].info.index), pictures[i].info);
}

/// A small view of another render would fill gaps from the wrong place.
void check_companions(const std::vector<Picture>& pictures, const Sources& sources) {
    const FrameInfo& main = pictures.front().info;
    for (std::size_t i = 1; i < pictures.size(); ++i) {
        const FrameInfo& other = pictures[i].info;
        const char* differs = other.scene != main.scene                                 ? "scene"
                              : other.geometry_fingerprint != main.geometry_fingerprint ? "geometry"
                              : other.time_s != main.time_s                             ? "time"
                              : other.head.position_m != main.head.position_m           ? "head position"
                              : other.head.orientation != main.head.orientation         ? "head orientation"
                              : other.ipd_m != main.ipd_m                               ? "distance between the eyes"
                              : other.exposure != main.exposure                         ? "exposure"
                              : other.seed != main.seed                                 ? "seed"
                                                                                        : nullptr;
        if (differs)
            throw InputError(expected_found(sources.tracks[i].folder.string() + ", frame " + std::to_string(main.index),
                                            "the " + std::string(differs) + " of " + sources.tracks[0].folder.string(),
                                            "another one; render both with one command, or use --fill none"));
    }
}

}  // namespace

namespace {

/// Depth tracks of a stream being written: each group's range, and what its steps and its clamping cost.
class DepthWriter {
public:
    DepthWriter(const DepthPlan& plan, const std::vector<std::int64_t>& frames, int gop) : plan_(plan) {
        for (const DepthTrack& track : plan.tracks)
            written_.push_back({DepthRanges(track, frames, gop), {}, 0, 0});
    }

    /// What goes with `picture`.
    void write(StreamWriter& writer, const Picture& picture, std::size_t position) {
        for (const auto& [track, distances_m] : picture.distances_m)
            write(writer, *track, distances_m.view(), {picture.info, position});
    }

    void report(EncodedTrack& encoded) const {
        for (std::size_t i = 0; i < plan_.tracks.size(); ++i)
            if (plan_.tracks[i].role == encoded.settings.role) {
                encoded.range = written_[i].first;
                encoded.bound_rad = written_[i].bound_rad;
                encoded.clamped_pixels = written_[i].clamped_pixels;
            }
    }

private:
    struct At {
        FrameInfo info;
        std::size_t position = 0;
    };
    void write(StreamWriter& writer, const DepthTrack& track, ImageView<const float> distances_m, At at) {
        Written& written = written_[std::size_t(&track - plan_.tracks.data())];
        at.info.depth_code = DepthCodeInfo{track.code, written.ranges.of(at.position), 0};
        const DepthRange& range = at.info.depth_code->range;
        written.bound_rad = std::max(written.bound_rad, quantisation_bound_rad(*make_depth_code(track.code), range));
        if (!written.first)
            written.first = range;
        if (track.code != DepthCodeId::lossless)
            for (int y = 0; y < distances_m.height; ++y)
                written.clamped_pixels += std::count_if(distances_m.row(y), distances_m.row(y) + distances_m.width,
                                                        [&](float r) { return r < float(range.near_m); });
        writer.write_depth(track.role, distances_m, at.info);
    }

    struct Written {
        DepthRanges ranges;
        std::optional<DepthRange> first;
        double bound_rad = 0;
        std::int64_t clamped_pixels = 0;
    };
    const DepthPlan& plan_;
    std::vector<Written> written_;  // as the plan's tracks
};

}  // namespace

EncodeReport encode_sequence(const EncodeRequest& request, const std::function<void(std::size_t)>& progress) {
    const auto start = Clock::now();
    const DisplayTransform display;
    const std::vector<std::int64_t>& frames = request.sources.frames;
    std::vector<Picture> pictures = read_frame(request.sources, {}, frames.front(), display);
    check_sizes(pictures, request.sources);
    std::vector<OneRender> renders;
    for (const SourceTrack& track : request.sources.tracks)
        renders.emplace_back(track.folder);
    check_one_render(pictures, request.sources, renders);
    check_companions(pictures, request.sources);
    const ColourTrial colour = try_colour(request.sources, request.settings);
    const DepthPlan plan = plan_depth(request.depth, {request.sources, request.settings, colour});
    if (!plan.tracks.empty())
        pictures = read_frame(request.sources, plan, frames.front(), display);
    EncodeReport report;
    report.settings = settings_for(request, pictures);
    report.settings.tracks.front().coding_loss = colour.loss;
    report.trial = plan.trial;
    report.images_left_out_share = plan.images_left_out_share;
    report.first = pictures.front().info;
    DepthWriter depths(plan, frames, request.settings.gop);
    StreamWriter writer(request.target, report.settings);
    const std::string kept =
        writer.unfinished_file().empty() ? "" : "; what was coded so far is kept in " + writer.unfinished_file();
    for (std::size_t i = 0; i < frames.size(); ++i) {
        // The next frame is read while this one is coded.
        std::future<std::vector<Picture>> next;
        if (i + 1 < frames.size())
            next = std::async(std::launch::async,
                              [&, index = frames[i + 1]] { return read_frame(request.sources, plan, index, display); });
        for (const Picture& picture : pictures) {
            const auto coding = Clock::now();
            writer.write(picture.role, picture.rgb.view(), picture.info);
            depths.write(writer, picture, i);
            report.encode_ms += milliseconds_since(coding);
            report.read_ms += picture.read_ms;
            report.display_ms += picture.display_ms;
            report.not_finite_samples += picture.not_finite_samples;
        }
        progress(i + 1);
        try {
            if (next.valid())
                pictures = next.get();
            check_one_render(pictures, request.sources, renders);
            check_companions(pictures, request.sources);
        } catch (const std::exception& error) {
            throw WorkError(error.what() + kept);
        }
    }
    const auto ending = Clock::now();
    writer.finish();
    report.encode_ms += milliseconds_since(ending);
    for (std::size_t i = 0; i < report.settings.tracks.size(); ++i) {
        const TrackSettings& track = report.settings.tracks[i];
        const auto distances = std::ranges::find(plan.tracks, track.role, &DepthTrack::role);
        const auto source = std::ranges::find(request.sources.tracks, track.role, &SourceTrack::role);
        report.tracks.push_back(
            {track, distances != plan.tracks.end() ? distances->source.folder : source->folder, writer.bytes()[i]});
        depths.report(report.tracks.back());
    }
    report.sphere_tag = writer.tags_sphere();
    report.wall_ms = milliseconds_since(start);
    return report;
}

}  // namespace equistream
