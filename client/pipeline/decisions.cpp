#include "decisions.h"

#include <equistream/depth_code.h>
#include <equistream/error.h>

#include <client/stages/stages.h>

#include <cmath>
#include <variant>

namespace equistream {

TrackRoles unneeded_roles(const PipelineChoice& choice) {
    const bool with_depth = find_engine(choice.engine).needs.any();
    TrackRoles needed;
    const auto need = [&](TrackRole role, bool is_needed) { needed[std::size_t(role)] = is_needed; };
    bool looks_points_up = false;
    for (const FillStage* stage : parse_fills(choice.fill)) {
        if (with_depth || !stage->needs_depth)
            needed |= stage->reads;
        looks_points_up = looks_points_up || stage->make()->wants_depth();
    }
    // All others are looked up by the eye's depth, mirrors too.
    // Without the pass for what lies around it a window would be all that is seen: the sphere is then shown alone.
    const bool with_window = needed[std::size_t(TrackRole::window)];
    need(TrackRole::main, true);
    for (const TrackRole colour : {TrackRole::main, TrackRole::window}) {
        if (colour == TrackRole::window && !with_window)
            continue;
        need(*depth_role_of(colour), with_depth && !is_cast(choice.depth));
        need(*reflections_role_of(colour), with_depth && (choice.mirrors || looks_points_up));
    }
    return ~needed;
}

bool counts_as_earlier(double earlier_s, double shown_s) {
    constexpr double max_age_s = 1;
    return earlier_s < shown_s && shown_s - earlier_s <= max_age_s;
}

bool counts_as_left(double earlier_s, double shown_s) {
    constexpr double max_age_s = 10;
    return earlier_s < shown_s && shown_s - earlier_s <= max_age_s;
}

bool mostly_overlap(const Camera& a, const Camera& b) {
    const auto *one = std::get_if<EquirectCamera>(&a), *other = std::get_if<EquirectCamera>(&b);
    if (one == nullptr || other == nullptr)
        return true;
    const auto middle = [](double from, double to) { return 0.5 * (from + to); };
    const LongitudeLatitudeRange &r = one->range, &s = other->range;
    const double apart_rad = std::abs(
        std::remainder(middle(r.longitude_min, r.longitude_max) - middle(s.longitude_min, s.longitude_max), 2 * pi));
    const double above_rad = std::abs(middle(r.latitude_min, r.latitude_max) - middle(s.latitude_min, s.latitude_max));
    return apart_rad < 0.5 * r.longitude_span() && above_rad < 0.5 * r.latitude_span();
}

ReliabilityOptions confidence_options(const FrameInfo& main, bool by_frames_depth, MirrorTreatment mirrors) {
    return confidence_options(by_frames_depth ? depth_tolerance_w(main.depth_code) : 0, visible_loss_of(main), mirrors);
}

ReliabilityOptions confidence_options(double depth_tolerance_w, const std::optional<VisibleLoss>& visible_loss,
                                      MirrorTreatment mirrors) {
    return {.depth_tolerance_w = depth_tolerance_w,
            .visible_loss = visible_loss,
            .specular_reworked = mirrors != MirrorTreatment::surface};
}

bool leaves_head_box(const Pose& eye, const FrameInfo& source) {
    constexpr double rounding_m = 1e-6;  // eyes at rest lie on the ball
    return glm::distance(eye.position_m, source.camera_pose.position_m) > head_box_radius(source) + rounding_m;
}

bool takes_right(const ReceivedFrame& frame, bool is_right_eye, const Pose& eye) {
    if (!frame.right || !frame.posed)
        return frame.right && is_right_eye;
    const auto distance_m = [&](const ReceivedPicture& picture) {
        return glm::distance(picture.info.camera_pose.position_m, eye.position_m);
    };
    return distance_m(*frame.right) < distance_m(frame.main);
}

namespace {

/// What a source is, as far as its depth goes.
std::string described(const DepthWish& wish, const DepthOffer& offer) {
    if (offer.folder)
        return wish.source + ", a folder of rendered frames" + (offer.plane ? "" : " without depth");
    if (!offer.plane)
        return wish.source + (offer.posed ? ", a stream without depth" : ", ordinary video");
    return wish.source + ", a stream" +
           (offer.code ? " of depth coded " + std::string(depth_code_names()[std::size_t(*offer.code)])
                       : std::string(" with depth"));
}

/// Of --depth. Planes that the method does not use are not missed.
void require_kind(const DepthWish& wish, const DepthOffer& offer, bool used) {
    const auto require = [&](bool good, const std::string& expected, const std::string& hint) {
        if (!good)
            throw InputError(expected_found("--depth " + wish.depth, expected, described(wish, offer) + hint));
    };
    if (is_cast(wish.depth) && !offer.scene)
        throw InputError(expected_found("--depth " + wish.depth,
                                        std::string("--scene S or --model M, to ") +
                                            (is_drawn(wish.depth) ? "draw" : "cast rays into"),
                                        "neither"));
    if (wish.depth == "stream")
        require(!offer.folder && (offer.plane || !used), "a stream with a depth track (encode --depth auto)",
                offer.folder && offer.plane ? " (--depth exact takes theirs)" : "");
    if (wish.depth == "exact")
        require(!used || (offer.plane && (offer.folder || offer.code == DepthCodeId::lossless)),
                "a folder of rendered frames with their depth, or a stream of lossless depth",
                !offer.folder && offer.plane ? " (--depth stream takes it)" : "");
}

std::string default_depth(const DepthOffer& offer) {
    if (offer.scene)
        return "ray";
    if (!offer.plane || !offer.posed)
        return "none";
    return offer.folder ? "exact" : "stream";
}

/// Of a method that needs the eyes' own.
InputError missing_eyes_depth(const DepthWish& wish, const DepthOffer& offer, const DepthChoice& choice) {
    const std::string method = wish.method_option + " " + choice.method;
    const bool can_ask = !wish.depth_option.empty();
    if (can_ask && choice.depth == "exact" && offer.folder)
        return InputError(expected_found(wish.depth_option + " exact",
                                         wish.scene_option + ", or a rendered depth plane of exactly the " +
                                             (offer.eye_without_plane == Eye::left ? "left" : "right") +
                                             " eye's view next to " + wish.source,
                                         "neither"));
    return InputError(expected_found(
        method, wish.scene_option + ", for the eyes' own depth, which no stream has (mesh and splat need none)",
        can_ask ? wish.depth_option + " " + choice.depth + " alone" : described(wish, offer)));
}

}  // namespace

DepthChoice choose_depth(const DepthWish& wish, const DepthOffer& offer) {
    DepthChoice choice{.method = wish.method, .depth = wish.depth, .notes = {}};
    const bool by_budget = wish.method == "auto";
    const DepthNeeds needs = wish.method.empty() || by_budget ? DepthNeeds{} : find_engine(wish.method).needs;
    require_kind(wish, offer, needs.any() || wish.method.empty());
    if (choice.depth.empty())
        choice.depth = default_depth(offer);
    const bool eyes_depth = offer.scene || (choice.depth == "exact" && !offer.eye_without_plane);
    if (choice.method.empty()) {
        choice.method = choice.depth == "none" ? "rotation" : eyes_depth ? "eye-depth" : "mesh";
        if (choice.depth == "none")
            choice.notes.push_back(
                "no scene, and no depth in " + wish.source +
                ": method rotation (the eye only turns); --scene S gives parallax, and so does a stream "
                "with depth (encode --depth auto)");
        else if (wish.depth.empty() && !offer.scene)
            choice.notes.push_back("no scene: depth is " +
                                   std::string(choice.depth == "exact" ? "the render's own" : "the stream's own") +
                                   ", method " + choice.method);
    }
    if (by_budget)
        return choice;
    const std::string method = wish.method_option + " " + choice.method;
    if (!offer.posed && choice.method != "rotation")
        throw InputError(expected_found(wish.source, "pictures tagged with their pose, for " + method,
                                        "ordinary video (" + wish.method_option + " rotation shows it)"));
    if (needs.any() && choice.depth == "none")
        throw InputError(expected_found(
            method, wish.scene_option + ", or a source with depth of its own, to have depth", described(wish, offer)));
    if (needs.eye && !eyes_depth)
        throw missing_eyes_depth(wish, offer, choice);
    if (!needs.any() && !wish.method.empty())
        choice.depth = "none";
    return choice;
}

std::optional<std::string> require_same_scene(const FrameInfo& first, const std::string& source,
                                              const SceneDescription& scene, const std::string& file) {
    const auto require_same = [&](const std::string& what, const std::string& rendered, const std::string& here) {
        if (rendered != here)
            throw InputError(expected_found(
                file, "the " + what + " '" + rendered + "' that " + source + " was rendered from", "'" + here + "'"));
    };
    require_same("scene", first.scene, scene.name);
    if (first.geometry_fingerprint.empty())
        return source + " carries no geometry fingerprint: assuming that it was rendered from " + file;
    require_same("geometry", first.geometry_fingerprint, scene.depth_of_geometry());
    return std::nullopt;
}

}  // namespace equistream
