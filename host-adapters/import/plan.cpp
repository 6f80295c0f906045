#include "import.h"

#include <equistream/aov.h>
#include <equistream/camera_limits.h>
#include <equistream/error.h>
#include <equistream/sequence.h>
#include <equistream/text.h>
#include <equistream/window.h>

#include <algorithm>
#include <set>

namespace equistream::files {

namespace {

template <typename Value>
void lay_over(Value& value, const std::optional<Value>& given) {
    if (given)
        value = *given;
}

class Planner {
public:
    Planner(const ImportSettings& settings, ImportPlan& plan) : settings_(settings), plan_(plan) {
        plan.files = find_files(settings.sources);
        all_frames_ = plan.files.frames;
        keep_frames_asked_for();
        for (const auto& file : plan.files.frames.front().files)
            files_.emplace_back(file);
    }

    void make() {
        const std::string first = plan_.files.frames.front().files.front().string();
        say(std::to_string(plan_.files.frames.size()) + " frames, " + size_text(files_[0].width(), files_[0].height()),
            "frames " + std::to_string(plan_.files.frames.front().index) + " to " +
                std::to_string(plan_.files.frames.back().index),
            "such as " + first);
        choose_preset();
        read_our_own();
        if (settings_.density > 0)
            place_window();
        else
            choose_camera();
        if (settings_.window && settings_.density == 0)
            choose_window();
        choose_depth_kind();
        choose_rate();
        choose_poses();
        map_views();
        choose_colour();
    }

private:
    const ForeignExr& file() const { return files_.front(); }
    template <typename Says>
    const ForeignExr& file_that(const Says& says) const {
        return first_that(files_, says);
    }
    /// The file that holds colour, or the first.
    const ForeignExr& colour_file() const {
        for (const MappedPlane& plane : plan_.views.front().map.planes)
            if (plane.plane == "colour")
                return files_[std::size_t(plane.set)];
        return file();
    }

    void say(std::string found, std::string taken_for, std::string why) {
        plan_.findings.push_back({std::move(found), std::move(taken_for), std::move(why)});
    }

    void keep_frames_asked_for() {
        if (!plan_.files.frames.empty()) {
            plan_.first_in_source = plan_.files.frames.front().index;
            plan_.last_in_source = plan_.files.frames.back().index;
        }
        const auto is_outside = [&](const auto& frame) {
            return frame.index < settings_.first_frame || frame.index > settings_.last_frame;
        };
        std::erase_if(plan_.files.frames, is_outside);
        std::erase_if(plan_.files.missing, is_outside);
        if (plan_.files.frames.empty())
            throw InputError(
                expected_found(settings_.sources.front(), "whole frames (in the range asked for)", "none"));
        if (!plan_.files.missing.empty()) {
            std::string names;
            for (std::size_t i = 0; i < std::min<std::size_t>(plan_.files.missing.size(), 5); ++i)
                names += (i == 0 ? "" : ", ") + plan_.files.missing[i].text;
            plan_.notes.push_back("missing and left out: " + names +
                                  (plan_.files.missing.size() > 5 ? " and more" : ""));
        }
    }

    /// Not of those asked for: files may name a command line that is another for each.
    std::string software_of_the_first() const {
        try {
            return ForeignExr(all_frames_.front().files.front()).software();
        } catch (const InputError&) {  // it is damaged, and need not be read
            return file().software();
        }
    }

    void choose_preset() {
        plan_.software = software_of_the_first();
        const bool guessed = settings_.preset == "auto";
        plan_.conventions = preset(guessed ? guess_preset(file()) : settings_.preset);
        say(plan_.software.empty() ? "no renderer named in the files" : "written by " + plan_.software,
            "conventions: " + plan_.conventions.name,
            !guessed                           ? "--preset"
            : plan_.conventions.name == "none" ? "no renderer was recognised"
                                               : "attributes and channel names");
        SourceConventions& c = plan_.conventions;
        const Overrides& o = settings_.overrides;
        lay_over(c.depth, o.depth);
        lay_over(c.depth_scale_m, o.depth_scale_m);
        c.near_plane_m *= c.depth_scale_m;  // what a renderer always has is in its scenes' unit
        lay_over(c.near_plane_m, o.near_plane_m);
        lay_over(c.miss_above, o.miss_above);
        lay_over(c.forward_at, o.forward_at);
        lay_over(c.normals, o.normals);
        lay_over(c.normals_encoded, o.normals_encoded);
        lay_over(c.mirrored, o.mirrored);
        lay_over(c.z_up, o.z_up);
        if (o.miss_value)
            c.miss_value = o.miss_value;
        if (o.backward)
            c.backward = o.backward;
        if (o.forward)
            c.forward = o.forward;
        c.channels = o.channels;
        // A channel that was named has a convention, if only ours.
        if (c.channels.contains("backward") && !c.backward)
            c.backward = MotionConvention{MotionEnds::to_previous, MotionUnit::pixels, false};
        if (c.channels.contains("forward") && !c.forward)
            c.forward = MotionConvention{MotionEnds::to_next, MotionUnit::pixels, false};
    }

    /// What frames that `render` or `import` wrote say of themselves, as long as no program has dropped it.
    void read_our_own() {
        plan_.shared = settings_.info;
        if (plan_.conventions.name != "equistream")
            return;
        try {
            own_ = read_exr_info(file().file());
        } catch (const InputError&) {
            return;
        }
        if (settings_.density == 0 && (own_->patches || own_->window_columns > 0))
            throw InputError(expected_found(file().file().string(), "whole pictures (or --window X,Y and --density)",
                                            own_->patches ? "an atlas of patches" : "a window"));
        const auto take = [&](const char* option, auto FrameInfo::*member) {
            if (!settings_.told.contains(option))
                plan_.shared.*member = *own_.*member;
        };
        take("--ipd", &FrameInfo::ipd_m);
        take("--lean", &FrameInfo::head_radius_m);
        take("--lock", &FrameInfo::lock);
        take("--exposure", &FrameInfo::exposure);
        take("--name", &FrameInfo::scene);
        take("--eye", &FrameInfo::eye);
        say("attributes of equistream",
            formatted("exposure %g, eyes %g m apart", plan_.shared.exposure, plan_.shared.ipd_m),
            "attributes; --exposure, --ipd and others override");
    }

    void choose_camera() {
        const int width = file().width(), height = file().height();
        // Of our own frames, unless an option says something else.
        const bool says_itself = own_ && settings_.camera == "auto" && !settings_.fov_x_rad;
        const auto* own_view = says_itself ? std::get_if<PerspectiveCamera>(&own_->camera) : nullptr;
        const auto* own_sphere = says_itself ? std::get_if<EquirectCamera>(&own_->camera) : nullptr;
        const auto fov_of = [&](const ForeignExr& f) { return fov_of_attributes(f, plan_.conventions); };
        const auto of_file = own_view != nullptr ? own_view->fov_x_rad : fov_of(file_that(fov_of));
        const std::optional<double> fov_rad = settings_.fov_x_rad ? settings_.fov_x_rad : of_file;
        const std::string why_view = settings_.fov_x_rad ? "--fov" : "attributes worldToCamera and worldToNDC";
        const bool has_range = !is_centred_full_sphere(settings_.range);
        const LongitudeLatitudeRange range = own_sphere != nullptr && !has_range ? own_sphere->range : settings_.range;
        std::string why = "--camera";
        plan_.ods = settings_.camera == "ods" || (settings_.camera == "auto" && file().says_ods());
        bool sphere = settings_.camera == "equirect" || plan_.ods;
        if (says_itself || (settings_.camera == "auto" && plan_.ods)) {
            why = "attribute equistream:camera";
            sphere = own_view == nullptr;
        } else if (settings_.camera == "auto") {
            sphere = width == 2 * height && !fov_rad;
            why = sphere ? "twice as wide as high" : why_view;
            if (!sphere && !fov_rad)
                throw InputError(expected_found(
                    file().file().string(),
                    "2:1 for a sphere, --camera equirect (with --range), or --fov for a perspective view",
                    size_text(width, height)));
        }
        if (!sphere && !fov_rad)
            throw InputError(expected_found("--camera perspective", "--fov DEG", "none"));
        const Overrides& asked = settings_.overrides;
        const std::string of_a_sphere = has_range          ? "--range"
                                        : asked.mirrored   ? "--mirrored"
                                        : asked.forward_at ? "--forward-at"
                                                           : "";
        if (!sphere && !of_a_sphere.empty())
            throw InputError(expected_found(of_a_sphere, "a sphere (--camera equirect)", "a perspective view"));
        if (sphere && settings_.fov_x_rad)
            throw InputError(expected_found("--fov", "a perspective view (--camera perspective)", "a sphere"));
        if (sphere)
            plan_.camera = EquirectCamera{width, height, range};
        else
            plan_.camera = PerspectiveCamera{width, height, *fov_rad};
        std::string text = !sphere                  ? formatted("perspective, %g degrees", *fov_rad * 180 / pi)
                           : range.is_full_sphere() ? "equirect, the full sphere"
                                                    : "equirect, a part";
        if (sphere)
            text += looking_text();
        if (plan_.ods)
            text = "omnidirectional stereo, " + text;
        say(size_text(width, height), text, why);
        say_up();
    }

    std::string looking_text() const {
        const SourceConventions& c = plan_.conventions;
        return formatted(", looking at %g of its width", c.forward_at) + (c.mirrored ? " (after mirroring)" : "");
    }
    void say_up() {
        if (plan_.conventions.z_up)
            say("the source's world", "+Z up, turned into +Y up", "conventions " + plan_.conventions.name);
    }

    /// Of pictures that are windows themselves. `--window` places them as they are written; on a mirrored sphere they
    /// move to the other side.
    void place_window() {
        const int width = file().width(), height = file().height();
        const WindowGrid grid{settings_.density, settings_.density / 2, width, height};
        if (const auto problem = window_grid_problem(grid))
            throw InputError(file().file().string() + ": --" + *problem);
        if (const auto problem = window_place_problem(grid, settings_.corner))
            throw InputError("--window: " + *problem);
        WindowPlace place = settings_.corner;
        if (plan_.conventions.mirrored)
            place.x = (2 * grid.columns - place.x - width) % grid.columns;
        plan_.window = grid;
        plan_.corner = place;
        plan_.camera = window_camera(grid, place);
        say(size_text(width, height),
            formatted("a window of a sphere of %d columns, at %d,%d", grid.columns, place.x, place.y) + looking_text(),
            "--window and --density");
        say_up();
    }

    /// As large as the smallest of all files of the source: frames imported by parts are those of one import.
    void choose_window() {
        const auto* sphere = std::get_if<EquirectCamera>(&plan_.camera);
        if (sphere == nullptr)
            throw InputError(expected_found("--window", "windows of a whole sphere", "a perspective view"));
        if (!sphere->range.is_full_sphere())
            throw InputError(expected_found("--window", "windows of a whole sphere", "a part of one"));
        if (!is_centred_full_sphere(sphere->range))
            throw InputError(expected_found("--window",
                                            "windows of a whole sphere whose longitudes begin at -180 degrees",
                                            formatted("%g to %g degrees", sphere->range.longitude_min * 180 / pi,
                                                      sphere->range.longitude_max * 180 / pi)));
        for (const FileSets::Frame& frame : all_frames_) {
            std::vector<ForeignExr> opened;
            std::vector<const ForeignExr*> files;
            for (const auto& each : frame.files)
                opened.emplace_back(each);
            for (const ForeignExr& each : opened)
                files.push_back(&each);
            const auto found = window_of(files, plan_.conventions.mirrored);
            if (!found)
                throw InputError(
                    expected_found(frame.files.front().string(), "pixels on whole blocks of 16 of the sphere", "none"));
            if (!plan_.window)
                plan_.window = found->first;
            plan_.window->width = std::min(plan_.window->width, found->first.width);
            plan_.window->height = std::min(plan_.window->height, found->first.height);
        }
        if (const auto problem = window_grid_problem(*plan_.window))
            throw InputError(file().file().string() + ": " + *problem);
        say("data windows", "windows of " + size_text(plan_.window->width, plan_.window->height) + " of that sphere",
            "--window auto: whole blocks of 16 in all files");
    }

    void choose_depth_kind() {
        SourceConventions& c = plan_.conventions;
        const bool sphere = std::holds_alternative<EquirectCamera>(plan_.camera);
        if (sphere && c.depth == DepthKind::planar) {
            if (settings_.overrides.depth)
                throw InputError(
                    expected_found("--depth planar", "a perspective camera", "a sphere, which has no axis"));
            c.depth = DepthKind::radial;  // Cycles measures panoramas along the ray
        }
        if (c.depth == DepthKind::position && c.name == "equistream")
            throw InputError(expected_found("--depth position", "a source whose depth is a layer of points",
                                            "equistream's own frames, whose depth is distance"));
        // Of Mitsuba's sensors ours alone is a sphere, and it measures from its centre unless it is told otherwise.
        if ((sphere || c.depth == DepthKind::position) && !settings_.overrides.near_plane_m)
            c.near_plane_m = 0;
    }

    void choose_rate() {
        const auto of_file = file_that(&ForeignExr::frames_per_second).frames_per_second();
        plan_.frames_per_second = settings_.frames_per_second.value_or(of_file.value_or(30));
        say(of_file ? formatted("framesPerSecond %g", *of_file) : "no frame rate",
            formatted("%g frames a second", plan_.frames_per_second),
            settings_.frames_per_second ? "--fps"
            : of_file                   ? "attribute"
                                        : "default; set --fps");
        const std::int64_t last = plan_.files.frames.back().index;
        if (const auto mismatch = range_mismatch(double(last) / plan_.frames_per_second, -max_time_s, max_time_s))
            throw InputError(expected_found("time of frame " + std::to_string(last) + " in seconds", mismatch->expected,
                                            mismatch->found));
    }

    void choose_poses() {
        if (!settings_.path.empty()) {
            plan_.path = read_path_csv(settings_.path);
            say(settings_.path.string(), std::to_string(plan_.path.keys().size()) + " poses of the head", "--path");
            if (const std::string note = clock_note(plan_.path, settings_.path.string()); !note.empty())
                plan_.notes.push_back(note);
            require_poses_of_frames();
            return;
        }
        if (own_) {
            plan_.poses_of_our_own = true;
            say("equistream:headPosition", "poses of the head", "attributes");
            return;
        }
        const ForeignExr& posed = file_that(&ForeignExr::world_to_camera);
        if (!posed.world_to_camera()) {
            say("no poses", "every frame at the origin, looking along -Z", "set --path CSV");
            return;
        }
        plan_.poses_in_attributes = true;
        std::string taken_for;
        pose_of_attribute(posed, plan_.conventions, taken_for);
        const double scale_m = plan_.conventions.depth_scale_m;
        say("worldToCamera",
            "poses of the camera: " + taken_for + (scale_m == 1 ? "" : formatted(", %g m a unit", scale_m)),
            "attribute");
    }

    /// Of a path whose head does not rest. Frames a little beyond its ends take the pose there.
    void require_poses_of_frames() {
        const std::vector<PosePath::Key>& keys = plan_.path.keys();
        if (keys.size() < 2)
            return;
        const double rate = plan_.frames_per_second, slack_s = 0.5 / rate;
        const double from_s = keys.front().time_s - slack_s, to_s = keys.back().time_s + slack_s;
        const auto is_outside = [&](const FileSets::Frame& frame) {
            return double(frame.index) / rate < from_s || double(frame.index) / rate > to_s;
        };
        const std::vector<FileSets::Frame>& frames = plan_.files.frames;
        const auto outside = std::ranges::count_if(frames, is_outside);
        if (outside == 0)
            return;
        const std::string span = formatted("%g to %g s", keys.front().time_s, keys.back().time_s);
        if (outside == std::ssize(frames))
            throw InputError(
                expected_found("--path " + settings_.path.string(),
                               formatted("poses from %g to %g s, when frames %lld to %lld are at %g a second (--fps)",
                                         double(frames.front().index) / rate, double(frames.back().index) / rate,
                                         static_cast<long long>(frames.front().index),
                                         static_cast<long long>(frames.back().index), rate),
                               span));
        plan_.notes.push_back(std::to_string(outside) + " of " + std::to_string(frames.size()) +
                              " frames lie outside the path's " + span + ": they get the pose at its end");
    }

    void choose_colour() {
        if (settings_.colour_space != "auto") {
            plan_.colour_to_rec709 = to_rec709(named_chromaticities(settings_.colour_space), "--colour-space");
            say("colour", settings_.colour_space + " to linear Rec.709", "--colour-space");
            return;
        }
        const auto stored = colour_file().chromaticities();
        plan_.colour_to_rec709 = to_rec709(stored.value_or(rec709_chromaticities), colour_file().file().string());
        const bool other = plan_.colour_to_rec709 != glm::dmat3(1);
        say(stored ? "chromaticities" : "no chromaticities", other ? "converted to linear Rec.709" : "linear Rec.709",
            stored ? "attribute" : "default; set --colour-space");
    }

    void map_views() {
        plan_.conventions.takes_guides = settings_.denoise != DenoiseQuality::off;
        std::vector<const ForeignExr*> files;
        std::set<std::string> views;
        for (const ForeignExr& each : files_) {
            files.push_back(&each);
            for (const ForeignChannel& channel : each.channels())
                views.insert(channel.view);
        }
        if (views.size() > 1)
            views.erase("");
        if (views.contains("center") && views.contains("centre"))
            throw InputError(expected_found(file().file().string(), "one view named center or centre", "both"));
        for (const std::string& view : views) {
            PlannedView planned{view, plan_.shared.eye,
                                map_channels(files, plan_.files.stems, view, plan_.conventions)};
            const auto eye = std::ranges::find(eye_names, view == "center" ? "centre" : view);
            const bool is_eye = eye != std::end(eye_names);
            if (is_eye)
                planned.eye = static_cast<Eye>(eye - std::begin(eye_names));
            if (plan_.ods && planned.eye == Eye::centre)
                throw InputError(expected_found(
                    file().file().string(), "views left and right of omnidirectional stereo, or --eye left or right",
                    view.empty() ? "no views" : "view " + view));
            if (!is_eye && !view.empty() && views.size() > 1) {
                plan_.notes.push_back("view " + view + " is left out: expected left, right or centre");
                continue;
            }
            list(planned);
            plan_.views.push_back(std::move(planned));
        }
        if (plan_.poses_in_attributes && plan_.views.size() > 1 && !plan_.ods)
            throw InputError(expected_found(file().file().string(),
                                            "--path CSV for several views, as worldToCamera is read for the first only",
                                            std::to_string(plan_.views.size()) + " views"));
        if (plan_.window && plan_.views.size() > 1)
            throw InputError(expected_found("--window", "one view", std::to_string(plan_.views.size())));
        if (plan_.views.empty())
            throw InputError(expected_found(file().file().string(), "a view left, right or centre", "none of them"));
    }

    void list(const PlannedView& planned) {
        const std::string view = planned.view.empty() ? "" : planned.view + ": ";
        for (const MappedPlane& plane : planned.map.planes) {
            std::string channels;
            for (const ForeignChannel& channel : plane.channels)
                channels += (channels.empty() ? "" : " ") + channel.name;
            say(view + channels, taken_for(plane.plane), plane.why);
        }
        for (const LeftOut& left : planned.map.left_out)
            say(view + left.channels, "left out", left.why);
        if (planned.map.planes.empty())
            throw InputError(
                expected_found(file().file().string(), "channels with known names (--channels names others)", "none"));
        if (std::ranges::none_of(planned.map.planes, [](const MappedPlane& p) { return p.plane == "colour"; }))
            plan_.notes.push_back(view + "no colour was found: encode and play need it");
    }

    std::string taken_for(const std::string& plane) const {
        const SourceConventions& c = plan_.conventions;
        if (plane != "depth")
            return plane;
        constexpr const char* kinds[] = {"along the ray", "along the axis", "length of the point"};
        std::string text = std::string("depth, ") + kinds[int(c.depth)];
        if (c.depth_scale_m != 1)
            text += formatted(", %g m a unit", c.depth_scale_m);
        if (c.near_plane_m != 0)
            text += formatted(", from a near plane at %g m", c.near_plane_m);
        return text + (c.miss_value ? formatted(", %g: a miss", *c.miss_value)
                                    : formatted(", from %g on a miss", c.miss_above));
    }

    const ImportSettings& settings_;
    ImportPlan& plan_;
    std::vector<FileSets::Frame> all_frames_;  // of the source
    std::vector<ForeignExr> files_;
    std::optional<FrameInfo> own_;  // what the first says, where it is a frame of our own
};

}  // namespace

std::string ImportPlan::table() const {
    std::size_t widths[2] = {5, 9};
    for (const Finding& finding : findings) {
        widths[0] = std::max(widths[0], std::min<std::size_t>(finding.found.size(), 48));
        widths[1] = std::max(widths[1], std::min<std::size_t>(finding.taken_for.size(), 60));
    }
    const auto row = [&](const Finding& f) {
        return formatted("%-*s  %-*s  %s\n", int(widths[0]), f.found.c_str(), int(widths[1]), f.taken_for.c_str(),
                         f.why.c_str());
    };
    std::string text = row({"found", "read as", "reason"});
    for (const Finding& finding : findings)
        text += row(finding);
    for (const std::string& note : notes)
        text += "note: " + note + "\n";
    return text;
}

ImportPlan make_plan(const ImportSettings& settings) {
    ImportPlan plan;
    Planner(settings, plan).make();
    return plan;
}

}  // namespace equistream::files
