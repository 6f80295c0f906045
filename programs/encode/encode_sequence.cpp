#include "encode_sequence.h"

#include "source_pictures.h"

#include <equistream/colour.h>
#include <equistream/elapsed.h>
#include <equistream/error.h>
#include <equistream/sequence.h>
#include <equistream/text.h>
#include <equistream/window.h>

#include <algorithm>
#include <cmath>
#include <future>
#include <map>

namespace equistream {

namespace {

StreamSettings settings_for(const EncodeRequest& request, const std::vector<Picture>& first) {
    StreamSettings settings = request.settings;
    settings.tracks.clear();
    const bool has_window = std::ranges::find(first, TrackRole::window, &Picture::role) != first.end();
    for (const Picture& picture : first) {
        settings.tracks.push_back({picture.role, picture.width(), picture.height()});
        if (picture.role == TrackRole::main && has_window)
            settings.tracks.back().crf = base_crf(request.settings.crf);
        if (picture.role != TrackRole::main && picture.role != TrackRole::window)
            settings.tracks.back().crf =
                request.fill_crf.value_or(default_fill_crf(picture.role, request.settings.crf));
        for (const auto& [track, distances_m] : picture.distances_m)
            settings.tracks.push_back({distances_role(picture, *track), distances_m.width(), distances_m.height(),
                                       track->code, track->crf, is_halved(*track, distances_m)});
    }
    settings.frames_per_second = first.front().info.frames_per_second;
    settings.scene = first.front().info.scene;
    const auto* sphere = std::get_if<EquirectCamera>(&first.front().info.camera);
    if (sphere != nullptr)
        settings.sphere = sphere->range;
    settings.pictures = static_cast<std::uint32_t>(request.sources.frames.size());
    settings.stereo = request.sources.packing;
    settings.tagged = first.front().is_posed;
    cli::require(settings.tagged || first.front().distances_m.empty(), "--depth",
                 "none, as the eyes do not share one head pose", "depth");
    if (settings.stereo != StereoPacking::none)
        settings.baseline_m = first.front().info.ipd_m;
    return settings;
}

/// Each option of how depth is coded wants a track that it changes.
void require_depth_for_its_options(const DepthRequest& request, const DepthPlan& plan) {
    const auto any = [&](const auto& suits) { return std::ranges::any_of(plan.tracks, suits, &DepthTrack::role); };
    const bool beside_hidden = any([](TrackRole role) { return role != TrackRole::hidden_depth; });
    const char* found = plan.tracks.empty() ? "none"
                        : beside_hidden     ? "none for main"
                                            : "depth of the hidden layer only";
    const auto check = [&](const char* option, bool given, bool suits) {
        cli::require(!given || suits, option, "depth that is coded (--depth)", found);
    };
    check("--depth-crf", request.crf.has_value(), !plan.tracks.empty());
    check("--depth-share", request.share.has_value(), beside_hidden || plan.images_left_out_share.has_value());
    check("--depth-scale", request.halved == true, any(may_be_halved));
    const auto is_lossy = [](const DepthTrack& track) { return track.code != DepthCodeId::lossless; };
    cli::require(!request.crf || std::ranges::any_of(plan.tracks, is_lossy), "--depth-crf", "lossy depth",
                 "--depth lossless");
    const bool judges_images =
        request.images == ImagesTrack::if_cheap && (plan.images_left_out_share || any(is_reflections));
    cli::require(!request.crf || !request.share || judges_images, "--depth-share", "no --depth-crf, which replaces it",
                 in_words(request.crf.value_or(0)));
}

/// Depth tracks of a stream being written: each group's range, and what its steps and its clamping cost.
class DepthWriter {
public:
    DepthWriter(const DepthPlan& plan, const std::vector<std::int64_t>& frames, int gop) : plan_(plan) {
        for (const DepthTrack& track : plan.tracks)
            written_.push_back({.ranges = DepthRanges(track, frames, gop)});
    }

    /// What goes with `picture`.
    void write(StreamWriter& writer, const Picture& picture, std::size_t position) {
        for (const auto& [track, distances_m] : picture.distances_m) {
            Written& written = written_[std::size_t(track - plan_.tracks.data())];
            const DepthRange range = written.ranges.of(position);
            written.bound_rad =
                std::max(written.bound_rad, quantisation_bound_rad(*make_depth_code(track->code), range));
            if (!written.first)
                written.first = range;
            if (track->code != DepthCodeId::lossless)
                written.clamped_pixels[distances_role(picture, *track)] +=
                    std::ranges::count_if(distances_m.samples(), [&](float r) { return r < float(range.near_m); });
            FrameInfo info = picture.info;
            info.depth_code = DepthCodeInfo{track->code, range, 0};
            writer.write_depth(distances_role(picture, *track), distances_m.view(), info, picture.tile);
        }
    }

    /// `track`: the plan's.
    void report(const DepthTrack& track, EncodedTrack& encoded) const {
        for (std::size_t i = 0; i < plan_.tracks.size(); ++i)
            if (&plan_.tracks[i] == &track) {
                encoded.range = written_[i].first;
                encoded.bound_rad = written_[i].bound_rad;
                const auto clamped = written_[i].clamped_pixels.find(encoded.settings.role);
                encoded.clamped_pixels = clamped == written_[i].clamped_pixels.end() ? 0 : clamped->second;
            }
    }

private:
    struct Written {
        DepthRanges ranges;
        std::optional<DepthRange> first{};
        double bound_rad = 0;
        std::map<TrackRole, std::int64_t> clamped_pixels{};  ///< of tiles and of the base around them
    };
    const DepthPlan& plan_;
    std::vector<Written> written_;  // as the plan's tracks
};

/// Which of the source's a track was made of: tiles are main's.
TrackRole role_of_source(TrackRole role, const ReadPlan& plan) {
    if (!plan.tiles || !may_be_tiled(role))
        return role;
    return role == TrackRole::window         ? TrackRole::main
           : role == TrackRole::window_depth ? TrackRole::depth
                                             : TrackRole::reflections;
}

/// Tiles are one entry, with the sum of their bytes.
void report_tracks(const EncodeRequest& request, const ReadPlan& plan, const DepthWriter& depths,
                   const std::vector<std::int64_t>& bytes, EncodeReport& report) {
    for (std::size_t i = 0; i < report.settings.tracks.size(); ++i) {
        const TrackSettings& track = report.settings.tracks[i];
        const auto same = std::ranges::find_if(
            report.tracks, [&](const EncodedTrack& other) { return other.settings.role == track.role; });
        if (same != report.tracks.end()) {
            ++same->tiles;
            same->bytes += bytes[i];
            continue;
        }
        const TrackRole role = role_of_source(track.role, plan);
        const auto distances = std::ranges::find(plan.depth.tracks, role, &DepthTrack::role);
        const auto source = std::ranges::find(request.sources.tracks, role, &SourceTrack::role);
        const bool has_distances = distances != plan.depth.tracks.end();
        EncodedTrack encoded;
        encoded.settings = track;
        encoded.folder = has_distances ? distances->source.folder : source->folder;
        encoded.bytes = bytes[i];
        if (has_distances)
            depths.report(*distances, encoded);
        report.tracks.push_back(std::move(encoded));
    }
}

/// With the base's default where it was not given. Throws InputError where no such tiles can be made of the folder.
std::optional<TilePlan> checked_tiles(const EncodeRequest& request, const Picture& main) {
    if (!request.tiles)
        return std::nullopt;
    const int a_sixth = std::max(main.width() / 24 * 4, 2 * min_track_side);
    const TilePlan plan{request.tiles->grid, request.tiles->base_columns.value_or(a_sixth)};
    const std::string folder = request.sources.tracks.front().folder.string();
    const auto* sphere = std::get_if<EquirectCamera>(&main.info.camera);
    cli::require(sphere != nullptr && sphere->range.is_full_sphere() && main.width() == 2 * main.height(),
                 "--tiles: " + folder, "whole spheres, twice as wide as high", size_text(main.width(), main.height()));
    cli::require(is_centred_full_sphere(sphere->range), "--tiles: " + folder,
                 "spheres whose longitudes begin at -180 degrees",
                 formatted("%g", sphere->range.longitude_min * 180 / pi));
    cli::require(main.info.lock == AxisLock::world, "--tiles: " + folder,
                 "spheres whose axes stay with the world (render --lock world)", "axes that turn with the path");
    if (const auto problem = tile_problem(main.width(), plan.grid))
        throw InputError("--" + *problem);
    const WindowGrid tile = tile_grid(main.width(), plan.grid);
    cli::require(std::min(tile.width, tile.height) >= min_track_side, "--tiles",
                 "tiles of at least " + size_text(min_track_side, min_track_side) + " pixels",
                 size_text(tile.width, tile.height));
    cli::require(plan.base_columns % 4 == 0 && plan.base_columns >= 2 * min_track_side &&
                     plan.base_columns < main.width(),
                 "--base",
                 "a multiple of 4 from " + std::to_string(2 * min_track_side) + " on, below the sphere's " +
                     std::to_string(main.width()),
                 std::to_string(plan.base_columns));
    return plan;
}

/// Streams do without the figure where it cannot be had.
void measure_coding(ColourTrials& trials, EncodeReport& report) {
    try {
        report.colour = trials.get();
    } catch (const WorkError& error) {
        report.not_measured = error.what();
    }
}

}  // namespace

EncodeReport encode_sequence(const EncodeRequest& request, const std::function<void(std::size_t)>& progress) {
    const auto start = Clock::now();
    const ColourCoding coding(request.settings.transfer);
    const std::vector<std::int64_t>& frames = request.sources.frames;
    std::vector<Picture> pictures = read_frame(request.sources, {}, frames.front(), coding);
    check_sizes(pictures, request.sources);
    cli::require(!is_ods(pictures.front().info.camera) || request.sources.packing != StereoPacking::none,
                 request.sources.tracks.front().folder.string(),
                 "--stereo top-bottom or side-by-side, as omnidirectional stereo needs both eyes", "one eye");
    SourceRenders renders(request.sources);
    renders.check(pictures);
    ColourTrials trials(request.sources, request.settings);
    std::vector<std::string> for_motion;
    if (request.motion)
        for_motion = motion_planes(request.sources.tracks.front().folder / frame_file_name(frames.front()));
    const std::optional<TilePlan> tiles = checked_tiles(request, pictures.front());
    std::optional<WindowGrid> tile;
    if (tiles)
        tile = tile_grid(pictures.front().width(), tiles->grid);
    const ReadPlan plan = {plan_depth(request.depth, {request.sources, request.settings, trials, tile}), for_motion,
                           tiles};
    require_depth_for_its_options(request.depth, plan.depth);
    if (!plan.depth.tracks.empty() || request.motion || request.tiles)
        pictures = read_frame(request.sources, plan, frames.front(), coding);
    EncodeReport report;
    report.first = pictures.front().info;
    const auto coded = [&] { return plan.tiles ? in_tiles(std::move(pictures), *plan.tiles) : std::move(pictures); };
    std::vector<Picture> to_code = coded();
    report.settings = settings_for(request, to_code);
    report.trial = plan.depth.trial;
    report.images_left_out_share = plan.depth.images_left_out_share;
    if (request.motion)
        report.motion.emplace();
    DepthWriter depths(plan.depth, frames, request.settings.gop);
    StreamWriter writer(request.target, report.settings);
    const std::string kept =
        writer.unfinished_file().empty() ? "" : "; what was coded so far is kept in " + writer.unfinished_file();
    if (report.settings.tagged)
        measure_coding(trials, report);
    const TrackRole looked_at = plan.tiles ? TrackRole::window : request.sources.looked_at().role;
    progress(0);
    for (std::size_t i = 0; i < frames.size(); ++i) {
        // The next frame is read while this one is coded.
        std::future<std::vector<Picture>> next;
        if (i + 1 < frames.size())
            next = std::async(std::launch::async,
                              [&, index = frames[i + 1]] { return read_frame(request.sources, plan, index, coding); });
        const auto code = [&](const Picture& picture) {
            const auto began = Clock::now();
            FrameInfo info = picture.info;
            if (picture.role == looked_at)
                info.visible_loss = report.colour.loss;
            if (picture.motion)
                report.motion->add(*picture.motion, info);
            picture.write(writer, info);
            depths.write(writer, picture, i);
            report.encode_ms += milliseconds_since(began);
            report.read_ms += picture.read_ms;
            report.display_ms += picture.display_ms;
            report.motion_ms += picture.motion_ms;
            report.not_finite_samples += picture.not_finite_samples;
        };
        try {
            std::ranges::for_each(to_code, code);
        } catch (const InputError& error) {  // a later frame of this group, whose depths' range is looked for
            throw WorkError(error.what() + kept);
        }
        try {
            progress(i + 1);
            if (!next.valid())
                continue;
            pictures = next.get();
            renders.check(pictures);
            to_code = coded();
        } catch (const std::exception& error) {
            throw WorkError(error.what() + kept);
        }
    }
    const auto ending = Clock::now();
    writer.finish();
    report.encode_ms += milliseconds_since(ending);
    report_tracks(request, plan, depths, writer.bytes(), report);
    report.sphere_tag = writer.tags_sphere();
    report.wall_ms = milliseconds_since(start);
    return report;
}

}  // namespace equistream
