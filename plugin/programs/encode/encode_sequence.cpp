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
    std::int64_t not_finite_samples = 0;
    double read_ms = 0;
    double display_ms = 0;
};

Picture read_picture(const SourceTrack& track, std::int64_t index, const DisplayTransform& display) {
    Picture picture;
    picture.role = track.role;
    const auto file = track.folder / frame_file_name(index);
    auto start = Clock::now();
    const Frame frame = read_exr(file, {"colour"});
    picture.read_ms = milliseconds_since(start);
    const auto colour = frame.planes.find("colour");
    if (colour == frame.planes.end())
        throw InputError(expected_found(file.string(), "channels R, G and B", "none"));
    picture.info = frame.info;
    picture.info.index = index;  // a foreign file has its number in its name only
    start = Clock::now();
    picture.not_finite_samples = std::count_if(colour->second.samples().begin(), colour->second.samples().end(),
                                               [](float value) { return !std::isfinite(value); });
    picture.rgb = quantise_8bit(display.to_display(colour->second.view(), frame.info.exposure).view());
    picture.display_ms = milliseconds_since(start);
    return picture;
}

std::vector<Picture> read_frame(const Sources& sources, std::int64_t index, const DisplayTransform& display) {
    std::vector<Picture> pictures;
    for (const SourceTrack& track : sources.tracks)
        pictures.push_back(read_picture(track, index, display));
    return pictures;
}

StreamSettings settings_for(const EncodeRequest& request, const std::vector<Picture>& first) {
    StreamSettings settings = request.settings;
    settings.tracks.clear();
    for (const Picture& picture : first)
        settings.tracks.push_back({picture.role, picture.rgb.width(), picture.rgb.height()});
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

EncodeReport encode_sequence(const EncodeRequest& request, const std::function<void(std::size_t)>& progress) {
    const auto start = Clock::now();
    const DisplayTransform display;
    const std::vector<std::int64_t>& frames = request.sources.frames;
    std::vector<Picture> pictures = read_frame(request.sources, frames.front(), display);
    check_sizes(pictures, request.sources);
    std::vector<OneRender> renders;
    for (const SourceTrack& track : request.sources.tracks)
        renders.emplace_back(track.folder);
    check_one_render(pictures, request.sources, renders);
    check_companions(pictures, request.sources);
    EncodeReport report;
    report.settings = settings_for(request, pictures);
    report.first = pictures.front().info;
    StreamWriter writer(request.target, report.settings);
    const std::string kept =
        writer.unfinished_file().empty() ? "" : "; what was coded so far is kept in " + writer.unfinished_file();
    for (std::size_t i = 0; i < frames.size(); ++i) {
        // The next frame is read while this one is coded.
        std::future<std::vector<Picture>> next;
        if (i + 1 < frames.size())
            next = std::async(std::launch::async,
                              [&, index = frames[i + 1]] { return read_frame(request.sources, index, display); });
        for (const Picture& picture : pictures) {
            const auto coding = Clock::now();
            writer.write(picture.role, picture.rgb.view(), picture.info);
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
    for (std::size_t i = 0; i < request.sources.tracks.size(); ++i)
        report.tracks.push_back({report.settings.tracks[i], request.sources.tracks[i].folder, writer.bytes()[i]});
    report.sphere_tag = writer.tags_sphere();
    report.wall_ms = milliseconds_since(start);
    return report;
}

}  // namespace equistream
