#include "depth_tracks.h"

#include <equistream/bound.h>
#include <equistream/error.h>
#include <equistream/sequence.h>
#include <equistream/text.h>
#include <equistream/virtual_image.h>
#include <equistream/window.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace equistream {

namespace {

/// Groups whose first frames are looked at before a code is chosen.
constexpr std::size_t looked_at = 8;

/// What half a step may be where every second column and row is left out. Bits are so few then that steps of four
/// budgets drown in what the codec leaves; what is nearer than the range, though, is displaced the most of all.
constexpr double halved_budgets = 4;

/// Eyes are no farther from any origin of the picture's rays.
double box_radius_m(const FrameInfo& info) {
    double farthest_origin_m = 0;
    if (info.patches)
        for (const glm::dvec3& offset_m : info.patches->offsets_m)
            farthest_origin_m = std::max(farthest_origin_m, glm::length(offset_m));
    return head_box_radius(info.eye, info.head_radius_m, info.ipd_m) + farthest_origin_m;
}

struct Extent {
    double nearest_m = std::numeric_limits<double>::infinity();
    bool has_empty = false, has_surface = false;

    void take_in(const FloatImage& depth_m) {
        float nearest = std::numeric_limits<float>::infinity();
        bool empty = false, surface = false;
        for (const float r : depth_m.samples()) {
            nearest = r < nearest ? r : nearest;
            empty |= std::isnan(r);
            surface |= !std::isnan(r);
        }
        nearest_m = std::min(nearest_m, double(nearest));
        has_empty |= empty;
        has_surface |= surface;
    }
};

/// Takes what a frame's pictures show, of both eyes where they are packed.
void take_in(const DepthTrack& track, std::int64_t index, Extent& extent) {
    for (const std::filesystem::path& folder : {track.source.folder, track.right_eye}) {
        if (folder.empty())
            continue;
        const std::filesystem::path file = folder / frame_file_name(index);
        extent.take_in(distances_to_code(track, read_exr(file, planes_of(track.role)), file));
    }
}

/// Of the first frames of a few groups, spread over all of them.
Extent extent_of_some(const DepthTrack& track, const std::vector<std::int64_t>& frames, int gop) {
    const std::size_t groups = (frames.size() + std::size_t(gop) - 1) / std::size_t(gop);
    const std::size_t looks = std::min(groups, looked_at);
    Extent extent;
    for (std::size_t i = 0; i < looks; ++i)
        take_in(track, frames[i * groups / looks * std::size_t(gop)], extent);
    return extent;
}

/// A hidden layer is islands in a void, whose outlines cost more bits than all that is in them. Where it holds nothing
/// it gets main's own depth: no gap of main's shows that surface, so nothing is ever taken from there.
void close(FloatImage& hidden_m, const FloatImage& main_m) {
    if (hidden_m.samples().size() == main_m.samples().size())
        std::ranges::transform(hidden_m.samples(), main_m.samples(), hidden_m.samples().begin(),
                               [](float behind, float first) { return std::isnan(behind) ? first : behind; });
}

bool has_depth(const SourceTrack& track, std::int64_t index) {
    return read_exr(track.folder / frame_file_name(index)).planes.contains("depth");
}

/// In place of the images' distances: NaN where there is no mirror or glass, and where what it shows warps with its
/// surface within the budget, so that no client would look it up elsewhere.
void leave_images_only(const Frame& frame, double box_radius_m, FloatImage& image_m) {
    const double budget_rad = error_budget_rad(default_focal_length_px);
    const std::span<const float> mask = frame.planes.at("specular").samples();
    const std::span<const float> surface_m = frame.planes.at("depth").samples();
    for (std::size_t i = 0; i < mask.size(); ++i) {
        float& r = image_m.samples()[i];
        if (!(r > 0))
            r = std::numeric_limits<float>::infinity();
        if (!(mask[i] > min_specular) || displacement_bound_rad(surface_m[i], r, box_radius_m) <= budget_rad)
            r = std::numeric_limits<float>::quiet_NaN();
    }
}

Camera first_camera(const SourceTrack& track, const Sources& sources) {
    return read_exr_info(track.folder / frame_file_name(sources.frames.front())).camera;
}

/// The track of a picture's mirrors and glass, where it has some.
std::optional<DepthTrack> plan_images(const SourceTrack& source, const DepthRequest& request, const Beside& beside) {
    const Sources& sources = beside.sources;
    const TrackRole role = *reflections_role_of(source.role);
    const Frame first = read_exr(source.folder / frame_file_name(sources.frames.front()));  // whatever it has
    const std::vector<std::string> planes = planes_of(role);
    DepthTrack track{role, source, box_radius_m(first.info), DepthCodeId::w10, request.crf};
    if (!std::ranges::all_of(planes, [&](const std::string& plane) { return first.planes.contains(plane); }) ||
        !(track.box_radius_m > 0))
        return std::nullopt;
    const Extent extent = extent_of_some(track, sources.frames, beside.settings.gop);
    if (!extent.has_surface)
        return std::nullopt;
    track.code = code_for_bound(track.box_radius_m, extent.nearest_m, extent.has_empty, default_focal_length_px);
    return track;
}

/// Beside the depth that the plan has, which is chosen without it: behind foliage it would take all there is.
void add_images(const DepthRequest& request, const Beside& beside, DepthPlan& plan) {
    std::optional<DepthTrack> images = plan_images(beside.sources.looked_at(), request, beside);
    if (!images)
        return;
    if (!plan.tracks.empty())
        images->crf = plan.tracks.front().crf;
    if (request.images == ImagesTrack::if_cheap) {
        const double share = try_track(*images, beside).share();
        if (share > request.shares().front()) {
            plan.images_left_out_share = share;
            return;
        }
    }
    DepthRequest settled = request;
    if (!plan.tracks.empty()) {
        settled.code = depth_code_name(plan.tracks.front().code);
        settled.halved = plan.tracks.front().halved;
    }
    plan.tracks.push_back(std::move(*images));
    choose_depth(settled, beside, plan);
    if (beside.sources.looked_at().role == TrackRole::main)
        return;
    if (auto of_base = plan_images(beside.sources.tracks.front(), request, beside)) {
        of_base->crf = plan.tracks.front().crf;
        plan.tracks.push_back(std::move(*of_base));
    }
}

}  // namespace

bool can_be_halved(int width, int height) {
    return width % 4 == 0 && height % 4 == 0 && std::min(width, height) >= 2 * min_track_side;
}

std::vector<std::string> planes_of(TrackRole role) {
    return is_reflections(role) ? std::vector<std::string>{"specular", "depth", "virtual_depth"}
                                : std::vector<std::string>{"depth"};
}

FloatImage distances_to_code(const DepthTrack& track, const Frame& frame, const std::filesystem::path& file) {
    const std::vector<std::string> planes = planes_of(track.role);
    FloatImage distances_m = frame.planes.at(planes.back());  // a copy: main's depth is asked for by its mirrors too
    if (is_reflections(track.role))
        leave_images_only(frame, track.box_radius_m, distances_m);
    // Slots of an atlas that nobody uses may hold none; the atlas says which these are.
    if (track.role == TrackRole::patches_depth)
        std::ranges::replace_if(
            distances_m.samples(), [](float r) { return std::isnan(r); }, std::numeric_limits<float>::infinity());
    if (!track.main_folder.empty())
        close(distances_m, read_exr(track.main_folder / file.filename(), {"depth"}).planes.at("depth"));
    return distances_m;
}

DepthRanges::DepthRanges(const DepthTrack& track, std::vector<std::int64_t> frames, int gop)
    : track_(track), frames_(std::move(frames)), gop_(std::size_t(gop)) {}

DepthRange DepthRanges::of(std::size_t position, const DepthWay& way) {
    if (const std::size_t group = position / gop_; group != group_) {
        Extent extent;
        for (std::size_t i = group * gop_; i < std::min((group + 1) * gop_, frames_.size()); ++i)
            take_in(track_, frames_[i], extent);
        nearest_m_ = extent.nearest_m;
        has_empty_ = extent.has_empty;
        group_ = group;
    }
    const double budgets = way.halved ? halved_budgets : 1;
    return depth_range(*make_depth_code(way.code), track_.box_radius_m, nearest_m_, has_empty_,
                       track_.focal_length_px / budgets);
}

DepthPlan plan_depth(const DepthRequest& request, const Beside& beside) {
    const Sources& sources = beside.sources;
    DepthPlan plan;
    // Clients that have the scene cast main's depth and that of patches themselves. What lies behind the main picture
    // is of no use without its depth, which no client casts.
    const bool main_has_some = request.code != "none";
    const bool automatic = request.code == "auto" || !main_has_some;
    const auto planned = [&](const SourceTrack& source, double focal_length_px, const DepthRequest& asked) {
        const TrackRole role = *depth_role_of(source.role);
        const std::filesystem::path file = source.folder / frame_file_name(sources.frames.front());
        const FrameInfo info = read_exr(file, {"depth"}).info;
        if (is_ods(info.camera))
            throw InputError(expected_found("--depth: " + source.folder.string(), "spheres whose rays share one origin",
                                            "omnidirectional stereo, which clients turn without depth"));
        DepthTrack track{role, source, box_radius_m(info), DepthCodeId::w10, request.crf};
        const bool halves = may_be_halved(role) && asked.halved.value_or(false);
        int width = width_of(info.camera), height = height_of(info.camera);
        if (beside.tile && source.role == sources.looked_at().role) {
            width = beside.tile->width;
            height = beside.tile->height;
        }
        track.halved = halves && can_be_halved(width, height);
        if (halves && !track.halved && source.role == sources.looked_at().role)
            throw InputError(expected_found("--depth-scale", "1 where a side is no multiple of 4, or below 128 pixels",
                                            "2 for " + size_text(width, height)));
        track.focal_length_px = focal_length_px;
        if (role == TrackRole::depth)
            track.right_eye = sources.right_eye;
        if (!(track.box_radius_m > 0))
            throw InputError(
                expected_found(source.folder.string(),
                               "eyes that can leave the sphere's centre (render with --ipd or head_box.lean_m above 0)",
                               "neither; encode with --depth none"));
        if (automatic) {
            const Extent extent = extent_of_some(track, sources.frames, beside.settings.gop);
            track.code = code_for_bound(track.box_radius_m, extent.nearest_m, extent.has_empty, focal_length_px);
        } else {
            track.code = make_depth_code(request.code)->id();
        }
        if (role == TrackRole::hidden_depth && track.code != DepthCodeId::lossless &&
            has_depth(sources.tracks.front(), sources.frames.front()))
            track.main_folder = sources.tracks.front().folder;
        return track;
    };
    // What is chosen, is chosen for what eyes look at.
    const SourceTrack& looked_at = sources.looked_at();
    if (main_has_some)
        plan.tracks.push_back(planned(looked_at, default_focal_length_px, request));
    for (const SourceTrack& source : sources.tracks)
        if (source.role == TrackRole::hidden || (source.role == TrackRole::patches && main_has_some))
            plan.tracks.push_back(planned(source, default_focal_length_px, request));
    choose_depth(request, beside, plan);
    if (request.images != ImagesTrack::none && sources.packing == StereoPacking::none)
        add_images(request, beside, plan);
    if (looked_at.role != TrackRole::main && main_has_some) {
        DepthRequest settled = request;
        settled.halved = plan.tracks.front().halved;
        plan.tracks.push_back(planned(
            sources.tracks.front(),
            base_focal_length_px(first_camera(sources.tracks.front(), sources), first_camera(looked_at, sources)),
            settled));
        plan.tracks.back().crf = plan.tracks.front().crf;
    }
    return plan;
}

}  // namespace equistream
