#include "depth_tracks.h"

#include "depth_trial.h"

#include <equistream/bound.h>
#include <equistream/error.h>
#include <equistream/formatted.h>
#include <equistream/sequence.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace equistream {

namespace {

/// Groups whose first frames are looked at before a code is chosen.
constexpr std::size_t looked_at = 8;

/// Eyes are no farther from any origin of the picture's rays.
double box_radius_m(const FrameInfo& info) {
    double farthest_origin_m = 0;
    if (info.patches)
        for (const glm::dvec3& offset_m : info.patches->offsets_m)
            farthest_origin_m = std::max(farthest_origin_m, glm::length(offset_m));
    return head_box_radius(info.eye, info.lean_m, info.ipd_m) + farthest_origin_m;
}

struct Extent {
    double nearest_m = std::numeric_limits<double>::infinity();
    bool has_empty = false;

    void take_in(const FloatImage& depth_m) {
        float nearest = std::numeric_limits<float>::infinity();
        bool empty = false;
        for (const float r : depth_m.samples()) {
            nearest = r < nearest ? r : nearest;
            empty |= std::isnan(r);
        }
        nearest_m = std::min(nearest_m, double(nearest));
        has_empty |= empty;
    }
};

/// Nearest of the first frames of a few groups, spread over all of them.
double nearest_of_some(const SourceTrack& source, const std::vector<std::int64_t>& frames, int gop) {
    const std::size_t groups = (frames.size() + std::size_t(gop) - 1) / std::size_t(gop);
    const std::size_t looks = std::min(groups, looked_at);
    Extent extent;
    for (std::size_t i = 0; i < looks; ++i)
        extent.take_in(read_depth(source, frames[i * groups / looks * std::size_t(gop)]));
    return extent.nearest_m;
}

InputError no_depth(const std::filesystem::path& file) {
    return InputError(expected_found(file.string(), "a depth plane to code (render with --aovs depth)", "none"));
}

}  // namespace

FloatImage read_depth(const SourceTrack& source, std::int64_t index) {
    const std::filesystem::path file = source.folder / frame_file_name(index);
    Frame frame = read_exr(file, {"depth"});
    const auto depth = frame.planes.find("depth");
    if (depth == frame.planes.end())
        throw no_depth(file);
    return depth_to_code(std::move(depth->second), source.role);
}

FloatImage depth_to_code(FloatImage depth_m, TrackRole colour) {
    // Slots of an atlas that nobody uses may hold none; the atlas says which these are.
    if (colour == TrackRole::patches)
        std::ranges::replace_if(
            depth_m.samples(), [](float r) { return std::isnan(r); }, std::numeric_limits<float>::infinity());
    return depth_m;
}

DepthRanges::DepthRanges(const DepthTrack& track, std::vector<std::int64_t> frames, int gop)
    : track_(track), frames_(std::move(frames)), gop_(std::size_t(gop)) {}

const DepthRange& DepthRanges::of(std::size_t position) {
    const std::size_t group = position / gop_;
    if (group == group_)
        return range_;
    Extent extent;
    for (std::size_t i = group * gop_; i < std::min((group + 1) * gop_, frames_.size()); ++i)
        extent.take_in(read_depth(track_.source, frames_[i]));
    range_ = depth_range(*make_depth_code(track_.code), track_.box_radius_m, extent.nearest_m, default_focal_length_px);
    range_.has_empty = extent.has_empty;
    group_ = group;
    return range_;
}

DepthPlan plan_depth(const DepthRequest& request, const Sources& sources, const StreamSettings& settings) {
    DepthPlan plan;
    // What lies behind or beside the main picture is of no use without its depth: no client's scene gives that.
    const bool main_has_some = request.code != "none";
    const bool automatic = request.code == "auto" || !main_has_some;
    for (const SourceTrack& source : sources.tracks) {
        const auto role = depth_role_of(source.role);
        if (!role || (source.role == TrackRole::main && !main_has_some))
            continue;
        const std::filesystem::path file = source.folder / frame_file_name(sources.frames.front());
        const Frame first = read_exr(file, {"depth"});
        const FrameInfo& info = first.info;
        if (!first.planes.contains("depth")) {
            if (source.role != TrackRole::main)
                continue;
            throw no_depth(file);
        }
        DepthTrack track{*role, source, box_radius_m(info), DepthCodeId::w10, request.crf};
        if (!(track.box_radius_m > 0))
            throw InputError(expected_found(source.folder.string(),
                                            "eyes that may leave the sphere's centre, for depth to be of use",
                                            "no distance between the eyes and no lean"));
        track.code = automatic
                         ? code_for_bound(track.box_radius_m, nearest_of_some(source, sources.frames, settings.gop),
                                          default_focal_length_px)
                         : make_depth_code(request.code)->id();
        plan.tracks.push_back(std::move(track));
    }
    choose_crf(request, sources, settings, plan);
    return plan;
}

}  // namespace equistream
