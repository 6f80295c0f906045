#include "import.h"

#include <equistream/aov.h>
#include <equistream/error.h>
#include <equistream/formatted.h>
#include <equistream/sequence_writer.h>

#include <algorithm>

namespace equistream::files {

namespace {

class ViewImport {
public:
    ViewImport(const ImportSettings& settings, ImportPlan& plan, const PlannedView& view)
        : settings_(settings), plan_(plan), view_(view), writer_(sequence()) {}

    bool keeps(std::int64_t index) const { return writer_.keeps_frame(index); }

    void write(const FileSets::Frame& found) {
        std::vector<ForeignExr> files;
        std::vector<const ForeignExr*> borrowed;
        for (const auto& file : found.files)
            files.emplace_back(file);
        for (const ForeignExr& file : files)
            borrowed.push_back(&file);
        const ChannelMap map = map_channels(borrowed, plan_.files.stems, view_.view, plan_.conventions);
        require_same_planes(map, files.front());
        for (std::size_t set = 0; set < files.size(); ++set)
            files[set].decode(channels_of(map, int(set)));
        FrameInfo info = writer_.manifest().shared;
        info.index = found.index;
        info.time_s = double(found.index) / plan_.frames_per_second;
        Conversion conversion{plan_.conventions, plan_.camera, {}, {}, {}, plan_.colour_to_rec709};
        find_poses(files.front(), info, conversion);
        const std::size_t before = plan_.notes.size();
        writer_.write(convert_frame(borrowed, map, conversion, info, plan_.notes));
        if (plan_.notes.size() > before + 3)
            plan_.notes.resize(before + 3);
    }

private:
    SequenceSettings sequence() const {
        SequenceSettings sequence;
        sequence.folder = settings_.out / eye_names[int(view_.eye)];
        sequence.overwrite = settings_.overwrite;
        Manifest& manifest = sequence.manifest;
        manifest.shared = settings_.info;
        manifest.shared.eye = view_.eye;
        manifest.shared.camera = plan_.camera;
        manifest.shared.frames_per_second = plan_.frames_per_second;
        manifest.shared.host = quotable("imported" + (plan_.software.empty() ? "" : ", " + plan_.software), 200);
        for (const MappedPlane& plane : view_.map.planes)
            manifest.planes.push_back(plane.plane);
        manifest.command = settings_.command;
        manifest.single_part = false;
        std::string deciding = identity_of(plan_.conventions) + "\n";
        for (int i = 0; i < 9; ++i)
            deciding += formatted("%.17g ", plan_.colour_to_rec709[i / 3][i % 3]);
        for (const Finding& finding : plan_.findings)
            if (&finding != &plan_.findings.front())  // how many frames there are decides no pixel
                deciding += finding.found + "\n" + finding.taken_for + "\n";
        deciding += path_fingerprint(plan_.path);
        manifest.fingerprint = sequence_fingerprint(manifest, deciding);
        return sequence;
    }

    /// Ids that are stored as such are read as such.
    static std::vector<ForeignChannel> channels_of(const ChannelMap& map, int set) {
        std::vector<ForeignChannel> channels;
        for (const MappedPlane& plane : map.planes)
            for (const ForeignChannel& channel : plane.channels)
                if (plane.set == set && !(channel.is_id && find_aov(plane.plane)->type == SampleType::id))
                    channels.push_back(channel);
        return channels;
    }

    void require_same_planes(const ChannelMap& map, const ForeignExr& file) const {
        const auto names = [](const ChannelMap& m) {
            std::string text;
            for (const MappedPlane& plane : m.planes)
                text += (text.empty() ? "" : ", ") + plane.plane;
            return text;
        };
        if (names(map) != names(view_.map))
            throw InputError(expected_found(file.file().string(),
                                            "planes " + names(view_.map) + " as in the first file", names(map)));
    }

    Pose in_our_world(const Pose& pose) const { return plan_.conventions.z_up ? pose_from_z_up(pose) : pose; }

    Pose camera_at(const FrameInfo& info, double time_s) const {
        const Pose head = in_our_world(plan_.path.at(time_s));
        return camera_pose(plan_.camera, head, info.eye, info.ipd_m, info.lock);
    }

    void find_poses(const ForeignExr& file, FrameInfo& info, Conversion& conversion) const {
        conversion.pose_is_known = !plan_.path.empty() || plan_.poses_in_attributes;
        if (!plan_.path.empty()) {
            info.head = in_our_world(plan_.path.at(info.time_s));
            conversion.camera_pose = camera_at(info, info.time_s);
            const double step_s = 1 / plan_.frames_per_second;
            const bool first = info.index == plan_.first_in_source;
            const bool last = info.index == plan_.last_in_source;
            conversion.previous = camera_at(info, info.time_s - (first ? 0 : step_s));
            conversion.next = camera_at(info, info.time_s + (last ? 0 : step_s));
            return;
        }
        if (plan_.poses_in_attributes) {
            if (!file.world_to_camera())
                throw InputError(expected_found(file.file().string(), "worldToCamera as in the first file", "none"));
            std::string ignored;
            conversion.camera_pose = in_our_world(pose_of_attribute(file, plan_.conventions, ignored));
        }
        // The head is where this camera would be its eye.
        const Pose at_origin{{0, 0, 0}, conversion.camera_pose.orientation};
        info.head = {conversion.camera_pose.position_m - eye_position(at_origin, info.eye, info.ipd_m),
                     conversion.camera_pose.orientation};
    }

    const ImportSettings& settings_;
    ImportPlan& plan_;
    const PlannedView& view_;
    SequenceWriter writer_;
};

}  // namespace

void run_import(const ImportSettings& settings, ImportPlan& plan,
                const std::function<void(std::size_t, std::int64_t)>& done) {
    std::size_t count = 0;
    bool began = false;
    for (const PlannedView& view : plan.views) {
        ViewImport import(settings, plan, view);
        for (const FileSets::Frame& frame : plan.files.frames) {
            try {
                if (!import.keeps(frame.index)) {
                    import.write(frame);
                    began = true;
                }
            } catch (const InputError& problem) {
                if (began)
                    throw WorkError(problem.what());
                throw;
            }
            done(++count, frame.index);
        }
    }
}

}  // namespace equistream::files
