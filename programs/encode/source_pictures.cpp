#include "source_pictures.h"

#include <equistream/elapsed.h>
#include <equistream/sequence.h>
#include <equistream/stream.h>
#include <equistream/text.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace equistream {

namespace {

/// Depth of a colour track, and what its mirrors show, where the plan has them.
std::vector<const DepthTrack*> distances_of(const DepthPlan& plan, TrackRole colour) {
    std::vector<const DepthTrack*> tracks;
    for (const DepthTrack& track : plan.tracks)
        if (track.source.role == colour)
            tracks.push_back(&track);
    return tracks;
}

/// A coarser sphere's colours: means of the light that falls on its pixels.
FloatImage coarser(ImageView<const float> sphere, int columns) {
    FloatImage base(columns, columns / 2, sphere.channels);
    const WindowGrid all{sphere.width, sphere.height, sphere.width, sphere.height};
    WindowCover(all, {0, 0}, base.width(), base.height()).put(sphere, base.view());
    return base;
}

/// A coarser sphere's distances: the nearest of the four around each pixel's middle.
FloatImage coarser_distances(const FloatImage& sphere_m, int columns) {
    FloatImage base_m(columns, columns / 2, 1);
    const auto around = [](int pixel, int coarse, int fine) {
        const std::int64_t doubled = (2 * std::int64_t(pixel) + 1) * fine;
        return int((doubled - coarse) / (2 * std::int64_t(coarse)));  // the one whose middle is no later
    };
    for (int y = 0; y < base_m.height(); ++y)
        for (int x = 0; x < base_m.width(); ++x) {
            float nearest = std::numeric_limits<float>::quiet_NaN();
            for (int i = 0; i < 4; ++i) {
                const int column = std::min(around(x, base_m.width(), sphere_m.width()) + i % 2, sphere_m.width() - 1);
                const int row = std::min(around(y, base_m.height(), sphere_m.height()) + i / 2, sphere_m.height() - 1);
                nearest = std::fmin(nearest, *sphere_m.pixel(column, row));
            }
            *base_m.pixel(x, y) = nearest;
        }
    return base_m;
}

/// The sphere that all tiles of `sphere` lie in.
Picture base_of(const Picture& sphere, const FloatImage& linear, int columns, const ColourCoding& coding) {
    Picture base;
    base.info = sphere.info;
    base.info.camera = EquirectCamera{columns, columns / 2, {}};
    coding(coarser(linear.view(), columns).view(), sphere.info.exposure, base);
    for (const auto& [track, distances_m] : sphere.distances_m)
        base.distances_m.emplace_back(track, coarser_distances(distances_m, columns));
    base.not_finite_samples = sphere.not_finite_samples;
    base.read_ms = sphere.read_ms;
    base.display_ms = sphere.display_ms;
    return base;
}

Picture read_picture(const SourceTrack& track, std::int64_t index, const ReadPlan& plan, const ColourCoding& coding) {
    Picture picture;
    picture.role = track.role;
    const auto file = track.folder / frame_file_name(index);
    auto start = Clock::now();
    std::vector<std::string> planes = {"colour"};
    const std::vector<const DepthTrack*> tracks = distances_of(plan.depth, track.role);
    const bool finds_motion = !plan.motion_planes.empty() && track.role == TrackRole::main;
    for (const DepthTrack* distances : tracks)
        for (std::string& plane : planes_of(distances->role))
            planes.push_back(std::move(plane));
    if (finds_motion)
        for (const std::string& plane : plan.motion_planes)
            if (std::ranges::find(planes, plane) == planes.end())
                planes.push_back(plane);
    Frame frame = read_exr(file, planes);
    picture.read_ms = milliseconds_since(start);
    const FloatImage& colour = frame.planes.at("colour");
    if (finds_motion) {
        start = Clock::now();
        picture.motion = find_motion(track.folder, frame, index);
        picture.motion_ms = milliseconds_since(start);
    }
    for (const DepthTrack* distances : tracks)
        picture.distances_m.emplace_back(distances, distances_to_code(*distances, frame, file));
    picture.info = frame.info;
    number_as_named(picture.info, index);
    start = Clock::now();
    picture.not_finite_samples =
        std::ranges::count_if(colour.samples(), [](float value) { return !std::isfinite(value); });
    coding(colour.view(), frame.info.exposure, picture);
    if (plan.tiles && track.role == TrackRole::main)
        picture.base = std::make_shared<Picture>(base_of(picture, colour, plan.tiles->base_columns, coding));
    picture.display_ms = milliseconds_since(start);
    return picture;
}

}  // namespace

void Picture::write(StreamWriter& writer, const FrameInfo& tagged) const {
    if (pq.empty())
        writer.write(role, rgb.view(), tagged, tile);
    else
        writer.write_pq(role, pq.view(), tagged, tile);
}

std::vector<Picture> in_tiles(std::vector<Picture> pictures, const TilePlan& plan) {
    const Picture sphere = std::exchange(pictures.front(), Picture(*pictures.front().base));
    const WindowGrid grid = tile_grid(sphere.width(), plan.grid);
    for (int i = 0; i < plan.grid.count(); ++i) {
        Picture& tile = pictures.emplace_back();
        const WindowPlace place = tile_place(grid, plan.grid, i);
        tile.role = TrackRole::window;
        tile.tile = std::size_t(i);
        tile.info = sphere.info;
        tile.info.camera = window_camera(grid, place);
        tile.rgb = window_pixels(sphere.rgb, grid, place);
        tile.pq = window_pixels(sphere.pq, grid, place);
        for (const auto& [track, distances_m] : sphere.distances_m)
            tile.distances_m.emplace_back(track, window_pixels(distances_m, grid, place));
    }
    return pictures;
}

TrackRole distances_role(const Picture& picture, const DepthTrack& track) {
    return *(is_reflections(track.role) ? reflections_role_of(picture.role) : depth_role_of(picture.role));
}

bool is_halved(const DepthTrack& track, const FloatImage& distances_m) {
    return track.halved && can_be_halved(distances_m.width(), distances_m.height());
}

/// The main folder's picture and, where both eyes are packed, the other eye's in it.
std::vector<Picture> read_frame(const Sources& sources, const ReadPlan& plan, std::int64_t index,
                                const ColourCoding& coding) {
    std::vector<Picture> pictures;
    for (const SourceTrack& track : sources.tracks)
        pictures.push_back(read_picture(track, index, plan, coding));
    if (sources.packing == StereoPacking::none)
        return pictures;
    Picture& left = pictures.front();
    const Picture right = read_picture({TrackRole::main, sources.right_eye}, index, plan, coding);
    const std::string left_size = size_text(left.rgb.width(), left.rgb.height());
    const std::string right_size = size_text(right.rgb.width(), right.rgb.height());
    cli::require(left_size == right_size, (sources.right_eye / frame_file_name(index)).string(),
                 "the left eye's size, " + left_size, right_size);
    cli::require(std::holds_alternative<EquirectCamera>(left.info.camera),
                 (sources.tracks.front().folder / frame_file_name(index)).string(), "a sphere, for --stereo",
                 "a perspective view (--eye encodes one of two)");
    left.right_info = right.info;
    left.is_posed = is_right_eye_of(left.info, right.info);
    left.info.packing = sources.packing;
    left.rgb = packed_eyes(sources.packing, left.rgb.view(), right.rgb.view());
    for (std::size_t i = 0; i < left.distances_m.size(); ++i) {
        FloatImage& distances_m = left.distances_m[i].second;
        distances_m = packed_eyes(sources.packing, distances_m.view(), right.distances_m[i].second.view());
    }
    left.not_finite_samples += right.not_finite_samples;
    left.read_ms += right.read_ms;
    left.display_ms += right.display_ms;
    return pictures;
}

void check_sizes(const std::vector<Picture>& first, const Sources& sources) {
    for (std::size_t i = 0; i < first.size(); ++i) {
        const int width = first[i].width(), height = first[i].height();
        cli::require(width % 2 == 0 && height % 2 == 0, sources.tracks[i].folder.string(),
                     "frames of even width and height (4:2:0 video has no odd sizes)", size_text(width, height));
        // An eye's, of both in one picture: clients take them apart.
        const int eye_width = width_of(first[i].info.camera), eye_height = height_of(first[i].info.camera);
        cli::require(eye_width % 2 == 0 && eye_height % 2 == 0, sources.tracks[i].folder.string(),
                     "eyes of even width and height (4:2:0 video has no odd sizes)", size_text(eye_width, eye_height));
        const int columns = first[i].role == TrackRole::window ? window_grid_of(first[i].info).columns : 0;
        const int around = first.front().width();
        cli::require(columns == 0 || columns > around, sources.tracks[i].folder.string(),
                     "windows of a sphere of more columns than the " + std::to_string(around) + " of " +
                         sources.tracks.front().folder.string(),
                     std::to_string(columns));
    }
}

SourceRenders::SourceRenders(const Sources& sources) : sources_(sources) {
    for (const SourceTrack& track : sources.tracks)
        renders_.emplace_back(track.folder);
    if (sources.packing != StereoPacking::none)
        right_eye_.emplace(sources.right_eye);
}

void SourceRenders::check(const std::vector<Picture>& pictures) {
    const Picture& main = pictures.front();
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        const FrameInfo& info = pictures[i].info;
        renders_[i].require(sources_.tracks[i].folder / frame_file_name(info.index), info);
        const TrackRole role = pictures[i].role;
        require_companion(companion_of(role), sources_.tracks[0].folder, main.info, sources_.tracks[i].folder, info,
                          role == TrackRole::window ? ", or encode its folder alone" : ", or use --fill none");
    }
    if (!main.right_info)
        return;
    right_eye_->require(sources_.right_eye / frame_file_name(main.info.index), *main.right_info);
    require_companion(companion_of(TrackRole::main), sources_.tracks[0].folder, main.info, sources_.right_eye,
                      *main.right_info, "");
    if (!is_posed_)
        is_posed_ = main.is_posed;
    cli::require(*is_posed_ == main.is_posed,
                 "--stereo: " + sources_.right_eye.string() + ", frame " + std::to_string(main.info.index),
                 *is_posed_ ? "both eyes at one head pose, as in the first frame"
                            : "eyes at different head poses, as in the first frame",
                 *is_posed_ ? "different head poses" : "one head pose");
}

std::vector<std::string> motion_planes(const std::filesystem::path& file) {
    const Frame frame = read_exr(file);
    std::vector<std::string> planes = {"depth", "backward", "forward"};
    for (const std::string& plane : planes)
        cli::require(frame.planes.contains(plane), file.string(),
                     "plane '" + plane + "' for --motion (render --aovs depth,motion)", "none");
    if (frame.ids.contains("object_id"))
        planes.emplace_back("object_id");
    return planes;
}

FoundMotion find_motion(const std::filesystem::path& folder, const Frame& frame, std::int64_t index) {
    MotionPlanes planes{frame.info.camera, frame.info.camera_pose, frame.planes.at("depth").view(), {}, {}};
    if (const auto ids = frame.ids.find("object_id"); ids != frame.ids.end())
        planes.object_id = ids->second.view();
    FrameInfo here = frame.info;
    number_as_named(here, index);
    for (const auto& [step, name] : {std::pair{-1, "backward"}, {1, "forward"}}) {
        const std::filesystem::path beside = folder / frame_file_name(index + step);
        if (index + step < 0 || !std::filesystem::exists(beside))
            continue;
        // Where there is no frame, motion was made with a camera that rests, or with one that nobody knows.
        FrameInfo there = read_exr_info(beside);
        number_as_named(there, index + step);
        const double later_s = there.time_s - here.time_s;
        if (later_s * step > 0)
            planes.neighbours.push_back({there.camera_pose, later_s, frame.planes.find(name)->second.view()});
    }
    return planes.neighbours.empty() ? FoundMotion{} : find_moving_regions(planes);
}

void MotionTotals::add(const FoundMotion& found, FrameInfo& info) {
    info.moving = found.regions;
    while (motion_bytes(info) > max_motion_bytes) {
        info.moving.pop_back();
        ++left_out;
    }
    if (info.moving.empty())
        return;
    ++frames;
    max_regions = std::max(max_regions, std::int64_t(info.moving.size()));
    bytes += std::int64_t(motion_bytes(info));
    const double pixels_per_rad = default_focal_length_px, count = double(found.moving_pixels);
    const auto blend = [&](double& mean, double value_rad) {
        mean = (mean * pixels_ + value_rad * pixels_per_rad * count) / (pixels_ + count);
    };
    blend(mean_motion_px, found.mean_motion_rad);
    blend(mean_error_px, found.mean_error_rad);
    pixels_ += count;
    worst_p95_error_px = std::max(worst_p95_error_px, found.p95_error_rad * pixels_per_rad);
}

}  // namespace equistream
