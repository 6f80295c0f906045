#include "import.h"

#include <equistream/aov.h>
#include <equistream/error.h>
#include <equistream/file_kind.h>
#include <equistream/json_text.h>
#include <equistream/sequence.h>
#include <equistream/sequence_writer.h>
#include <equistream/text.h>

#include <plugin/denoise/denoiser.h>

#include <strings.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <map>
#include <set>

namespace equistream::files {

namespace fs = std::filesystem;

namespace {

/// Of all frames together, that are told.
constexpr std::size_t max_frame_notes = 20;

class ViewImport {
public:
    /// `denoiser`: null where nothing is denoised.
    ViewImport(const ImportSettings& settings, ImportPlan& plan, const PlannedView& view, Denoiser* denoiser)
        : settings_(settings), plan_(plan), view_(view), denoiser_(denoiser), writer_(sequence()) {}

    bool keeps(std::int64_t index) const { return writer_.keeps_frame(index); }

    /// Returns what was put right in the frame, a line each.
    std::vector<std::string> write(const FileSets::Frame& found) {
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
        Conversion conversion{plan_.conventions, camera(), {}, {}, {}, plan_.colour_to_rec709};
        if (plan_.corner)
            conversion.sphere_columns = plan_.window->columns;
        find_poses(files, info, conversion);
        std::vector<std::string> notes;
        Frame frame = convert_frame(borrowed, map, conversion, info, notes);
        if (plan_.window && !plan_.corner)
            cut_out(*plan_.window, place_in(borrowed), frame);
        if (denoiser_ != nullptr)
            denoiser_->denoise(frame);
        for (const MappedPlane& plane : map.planes)
            if (is_guide(plane))
                frame.planes.erase(plane.plane);
        writer_.write(frame);
        return notes;
    }

private:
    /// Read for the denoiser alone.
    static bool is_guide(const MappedPlane& plane) { return find_aov(plane.plane)->group == "guides"; }

    /// Its files may have changed since they were planned.
    WindowPlace place_in(const std::vector<const ForeignExr*>& files) const {
        const WindowGrid& grid = *plan_.window;
        const auto found = window_of(files, plan_.conventions.mirrored);
        if (!found || found->first.width < grid.width || found->first.height < grid.height)
            throw InputError(expected_found(files.front()->file().string(),
                                            size_text(grid.width, grid.height) +
                                                " pixels in whole blocks of 16, as the other files have",
                                            found ? size_text(found->first.width, found->first.height) : "none"));
        return found->second;
    }

    Camera camera() const {
        Camera camera = plan_.camera;
        if (plan_.ods)
            std::get<EquirectCamera>(camera).ods_side_m = ods_side_m(view_.eye, plan_.shared.ipd_m);
        return camera;
    }

    SequenceSettings sequence() const {
        SequenceSettings sequence;
        sequence.folder = settings_.out / (plan_.window ? "window" : eye_names[int(view_.eye)]);
        sequence.overwrite = settings_.overwrite;
        Manifest& manifest = sequence.manifest;
        manifest.shared = plan_.shared;
        manifest.shared.eye = view_.eye;
        manifest.shared.camera = camera();
        if (plan_.window) {
            manifest.shared.camera = window_shape(*plan_.window);
            manifest.shared.window_columns = plan_.window->columns;
        }
        manifest.shared.frames_per_second = plan_.frames_per_second;
        manifest.shared.host = as_json_holds(
            quotable("imported" + (plan_.software.empty() ? "" : ", " + plan_.software), 200), max_name_bytes);
        if (denoiser_ != nullptr)
            manifest.shared.denoiser = denoiser_->description();
        for (const MappedPlane& plane : view_.map.planes)
            if (!is_guide(plane))
                manifest.planes.push_back(plane.plane);
        manifest.command = settings_.command;
        manifest.single_part = false;
        std::string deciding = identity_of(plan_.conventions) + "\n";
        for (int i = 0; i < 9; ++i)
            deciding += formatted("%.17g ", plan_.colour_to_rec709[i / 3][i % 3]);
        for (const Finding& finding : plan_.findings)
            if (&finding != &plan_.findings.front() && finding.why != "--path")
                // how many frames there are, and how a path's file is called, decides no pixel
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
        return camera_pose(camera(), head, info.eye, info.ipd_m, info.lock);
    }

    void find_poses(const std::vector<ForeignExr>& files, FrameInfo& info, Conversion& conversion) const {
        conversion.pose_is_known = !plan_.path.empty() || plan_.poses_in_attributes || plan_.poses_of_our_own;
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
        if (plan_.poses_of_our_own) {
            const FrameInfo own = read_exr_info(files.front().file());
            info.head = own.head;
            // An import may have turned the sphere. Where an option says another eye, it is the head that stays.
            const bool is_another_eye =
                std::ranges::any_of(std::array{"--eye", "--ipd", "--lock"},
                                    [&](const char* option) { return settings_.told.contains(option); });
            conversion.camera_pose =
                is_another_eye ? camera_pose(camera(), info.head, info.eye, info.ipd_m, info.lock) : own.camera_pose;
            return;
        }
        if (plan_.poses_in_attributes) {
            const ForeignExr& file = first_that(files, &ForeignExr::world_to_camera);
            if (!file.world_to_camera())
                throw InputError(expected_found(file.file().string(), "worldToCamera as in the first file", "none"));
            std::string ignored;
            conversion.camera_pose = in_our_world(pose_of_attribute(file, plan_.conventions, ignored));
        }
        // The head is where this camera would be its eye.
        const Pose at_origin{{0, 0, 0}, conversion.camera_pose.orientation};
        const Eye seen_from = plan_.ods ? Eye::centre : info.eye;
        info.head = {conversion.camera_pose.position_m - eye_position(at_origin, seen_from, info.ipd_m),
                     conversion.camera_pose.orientation};
    }

    const ImportSettings& settings_;
    ImportPlan& plan_;
    const PlannedView& view_;
    Denoiser* const denoiser_;
    SequenceWriter writer_;
};

/// Frames in the same folder would be replaced, or removed by --overwrite, before they are read.
void require_other_folder(const fs::path& folder, const FileSets& sources) {
    std::set<fs::path> parents;
    for (const FileSets::Frame& frame : sources.frames)
        for (const fs::path& file : frame.files)
            parents.insert(file.parent_path().empty() ? fs::path(".") : file.parent_path());
    for (const fs::path& parent : parents) {
        std::error_code error;  // what is not there is no other's
        if (fs::equivalent(folder, parent, error))
            throw InputError(expected_found("--out: " + folder.string(), "another folder than what is imported lies in",
                                            parent.string()));
    }
}

}  // namespace

std::vector<ImportedFrames> run_import(const ImportSettings& settings, ImportPlan& plan,
                                       const std::function<void(std::size_t, std::int64_t)>& done) {
    std::vector<ImportedFrames> made;
    for (const PlannedView& view : plan.views) {
        made.push_back({settings.out / (plan.window ? "window" : eye_names[int(view.eye)])});
        require_other_folder(made.back().folder, plan.files);
    }
    std::size_t count = 0, of_frames = 0;
    bool began = false;
    std::optional<Denoiser> denoiser;
    if (settings.denoise != DenoiseQuality::off)
        denoiser.emplace(settings.denoise, 0);
    for (std::size_t i = 0; i < plan.views.size(); ++i) {
        ViewImport import(settings, plan, plan.views[i], denoiser ? &*denoiser : nullptr);
        for (const FileSets::Frame& frame : plan.files.frames) {
            try {
                if (import.keeps(frame.index)) {
                    ++made[i].kept;
                } else {
                    for (std::string& note : import.write(frame))
                        if (++of_frames <= max_frame_notes)
                            plan.notes.push_back(std::move(note));
                    began = true;
                    ++made[i].imported;
                }
            } catch (const InputError& problem) {
                if (began)
                    throw WorkError(problem.what());
                throw;
            }
            done(++count, frame.index);
        }
    }
    if (of_frames > max_frame_notes)
        plan.notes.push_back(formatted("%zu more notes like these", of_frames - max_frame_notes));
    return made;
}

namespace fs = std::filesystem;

namespace {

constexpr std::size_t max_missing_named = 1000;

/// What is before and behind a number.
struct Pattern {
    fs::path folder;
    std::string before, behind;
    auto operator<=>(const Pattern&) const = default;
};

using Numbered = std::map<std::int64_t, fs::path>;

std::string pattern_text(const Pattern& pattern) {
    return (pattern.folder / (pattern.before + "#" + pattern.behind)).string();
}

bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

struct PartedName {
    Pattern pattern;
    std::int64_t index = 0;
    bool is_beyond = false;  ///< its number is above the highest
};

/// The last run of digits before the extension is the frame's number. Without one it is frame 0, and so it is where the
/// number is above the highest, as a date with its time is.
PartedName parted(const fs::path& file) {
    const std::string name = file.filename().string();
    const std::size_t extension = std::min(name.rfind('.'), name.size());
    std::size_t end = extension;
    while (end > 0 && !is_digit(name[end - 1]))
        --end;
    std::size_t begin = end;
    while (begin > 0 && is_digit(name[begin - 1]))
        --begin;
    std::int64_t index = 0;
    const auto [last, error] = std::from_chars(name.data() + begin, name.data() + end, index);
    if (error != std::errc() || index > max_frame_index)
        return {{file.parent_path(), name.substr(0, extension), name.substr(extension)}, 0, begin != end};
    return {{file.parent_path(), name.substr(0, begin), name.substr(end)}, index};
}

InputError beyond_numbers(const fs::path& file, const std::string& found) {
    return InputError(
        expected_found(file.string(), "a frame's number from 0 to " + std::to_string(max_frame_index), found));
}

std::vector<fs::path> files_in(const fs::path& folder) {
    std::error_code error;
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder, error))
        if (strcasecmp(entry.path().extension().c_str(), ".exr") == 0 &&
            entry.path().filename().string().front() != '.')
            files.push_back(entry.path());
    if (error)
        throw InputError(expected_found(folder.string(), "a folder of EXR files", error.message()));
    std::ranges::sort(files);
    return files;
}

void add_pattern(const fs::path& source, std::map<Pattern, Numbered>& sets) {
    const std::string name = source.filename().string();
    const std::size_t begin = name.find('#');
    std::size_t end = begin;
    while (end < name.size() && name[end] == '#')
        ++end;
    const fs::path folder = source.has_parent_path() ? source.parent_path() : fs::path(".");
    const Pattern pattern{folder, name.substr(0, begin), name.substr(end)};
    Numbered& frames = sets[pattern];
    for (const fs::path& file : files_in(folder)) {
        const std::string found = file.filename().string();
        if (!found.starts_with(pattern.before) || !found.ends_with(pattern.behind) ||
            found.size() <= pattern.before.size() + pattern.behind.size())
            continue;
        const char* first = found.data() + pattern.before.size();
        const char* last = found.data() + found.size() - pattern.behind.size();
        std::int64_t index = 0;
        const auto [end_of_number, error] = std::from_chars(first, last, index);
        if (end_of_number != last || index < 0)
            continue;
        if (error != std::errc() || index > max_frame_index)
            throw beyond_numbers(file, std::string(first, last));
        frames[index] = file;
    }
    if (frames.empty())
        throw InputError(expected_found(source.string(), "files by this pattern", "none"));
}

/// Names without what they share: shot_beauty. and shot_depth. are beauty and depth.
std::vector<std::string> stems_of(const std::map<Pattern, Numbered>& sets) {
    std::vector<std::string> stems;
    for (const auto& [pattern, frames] : sets) {
        std::string stem = pattern.before;
        while (!stem.empty() && std::ispunct(static_cast<unsigned char>(stem.back())))
            stem.pop_back();
        const bool one_name =
            std::ranges::all_of(sets, [&, &own = pattern](const auto& s) { return s.first.before == own.before; });
        // A folder for each AOV, else a name.
        stems.push_back(stem.empty() || (sets.size() > 1 && one_name) ? pattern.folder.filename().string() : stem);
    }
    std::size_t shared = stems.size() > 1 ? stems.front().size() : 0;
    for (const std::string& stem : stems) {
        std::size_t same = 0;
        while (same < std::min(shared, stem.size()) && stem[same] == stems.front()[same])
            ++same;
        shared = same;
    }
    if (std::ranges::all_of(stems, [&](const std::string& stem) { return stem == stems.front(); }))
        return stems;
    // Whole words: of beauty1 and beauty2, or of abc and ab, nothing is shared.
    const auto is_of_a_word = [](const std::string& stem, std::size_t at) {
        return at < stem.size() && std::isalnum(static_cast<unsigned char>(stem[at]));
    };
    while (shared > 0 && is_of_a_word(stems.front(), shared - 1) &&
           std::ranges::any_of(stems, [&](const std::string& stem) { return is_of_a_word(stem, shared); }))
        --shared;
    for (std::string& stem : stems) {
        std::size_t begin = shared;
        while (shared > 0 && begin < stem.size() && !is_of_a_word(stem, begin))
            ++begin;
        stem = stem.substr(begin);
    }
    return stems;
}

}  // namespace

FileSets find_files(const std::vector<std::string>& sources) {
    std::map<Pattern, Numbered> sets;
    const std::string expected = "a folder, a file, or a pattern such as shot.####.exr";
    for (const std::string& source : sources) {
        std::vector<fs::path> files{source};
        const fs::file_type type = type_of(source, expected);
        if (type == fs::file_type::directory)
            files = files_in(source);
        else if (fs::path(source).filename().string().find('#') != std::string::npos) {
            add_pattern(source, sets);
            continue;
        } else if (type == fs::file_type::not_found)
            throw InputError(expected_found(source, expected, "no such file"));
        if (files.empty())
            throw InputError(expected_found(source, "EXR files", "none"));
        for (const fs::path& file : files) {
            const PartedName name = parted(file);
            if (name.is_beyond && (files.size() > 1 || sources.size() > 1))
                throw beyond_numbers(file, "a higher one; a file that is given alone is frame 0");
            sets[name.pattern][name.index] = file;
        }
    }
    FileSets found;
    found.stems = stems_of(sets);
    std::set<std::int64_t> indices;
    for (const auto& [pattern, frames] : sets)
        for (const auto& [index, file] : frames)
            indices.insert(index);
    for (const std::int64_t index : indices) {
        FileSets::Frame frame{index, {}};
        std::size_t set = 0;
        for (const auto& [pattern, frames] : sets) {
            if (const auto file = frames.find(index); file != frames.end())
                frame.files.push_back(file->second);
            else if (found.missing.size() < max_missing_named)
                found.missing.push_back(
                    {index, "frame " + std::to_string(index) + " of " +
                                (found.stems[set].empty() ? pattern_text(pattern) : found.stems[set])});
            ++set;
        }
        if (frame.files.size() == sets.size())
            found.frames.push_back(std::move(frame));
    }
    for (auto index = indices.begin(); index != indices.end() && std::next(index) != indices.end(); ++index)
        for (std::int64_t gap = *index + 1; gap < *std::next(index) && found.missing.size() < max_missing_named; ++gap)
            found.missing.push_back({gap, "frame " + std::to_string(gap)});
    return found;
}

}  // namespace equistream::files
