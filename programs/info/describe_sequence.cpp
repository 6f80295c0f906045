#include "describe.h"

#include <equistream/error.h>
#include <equistream/locks.h>
#include <equistream/picture.h>
#include <equistream/sequence.h>

#include <algorithm>
#include <utility>

namespace equistream {

namespace {

namespace fs = std::filesystem;

constexpr const char* known_folders[] = {"centre", "left", "right", "small", "hidden", "patches", "window"};

bool is_sequence(const fs::path& folder) {
    return fs::is_directory(folder) && (fs::exists(folder / "manifest.json") || !list_frames(folder).empty());
}

/// "0-4, 7, 9-12", grown by a run.
void add_run(std::string& text, std::int64_t first, std::int64_t last) {
    text += (text.empty() ? "" : ", ") + std::to_string(first) + (last > first ? "-" + std::to_string(last) : "");
}

std::string runs_text(const std::vector<std::int64_t>& indices) {
    std::string text;
    for (std::size_t first = 0, last; first < indices.size(); first = last + 1) {
        last = first;
        while (last + 1 < indices.size() && indices[last + 1] == indices[last] + 1)
            ++last;
        add_run(text, indices[first], indices[last]);
    }
    return text;
}

std::uintmax_t bytes_of(const fs::path& folder, const std::vector<std::int64_t>& indices) {
    std::uintmax_t bytes = 0;
    for (const std::int64_t index : indices)
        bytes += fs::file_size(folder / frame_file_name(index));
    return bytes;
}

/// Gaps between the first frame and the last; as runs, because a stray file may lie far off.
std::string gaps_text(const std::vector<std::int64_t>& indices) {
    std::string text;
    for (std::size_t i = 1; i < indices.size(); ++i)
        if (indices[i] > indices[i - 1] + 1)
            add_run(text, indices[i - 1] + 1, indices[i] - 1);
    return text;
}

void add_manifest(const fs::path& folder, Description& description) {
    if (!fs::exists(folder / "manifest.json")) {
        description.text += "  no manifest.json: not rendered by equistream, or not started\n";
        description.json["manifest"] = nullptr;
        return;
    }
    const Manifest manifest = read_manifest(folder);
    description.text += formatted("  rate       %g frames/s\n", manifest.shared.frames_per_second) +
                        shared_text(manifest.shared) + "  planes     " + shown(in_a_sentence(manifest.planes, ", ")) +
                        "\n  command    " + shown(manifest.command) + "\n";
    description.json["manifest"] = {{"shared", frame_json(manifest.shared)},
                                    {"planes", manifest.planes},
                                    {"command", manifest.command},
                                    {"fingerprint", manifest.fingerprint}};
}

void add_each_frame(const fs::path& folder, const std::vector<std::int64_t>& indices, const DescribeOptions& options,
                    Description& description) {
    FrameRun frames;
    Description list;
    cli::Progress progress("info", double(indices.size()), options.progress);
    for (const std::int64_t index : indices) {
        const FrameInfo frame = read_exr_info(folder / frame_file_name(index));
        frames.add(frame);
        list_frame(frame, options, list);
        progress.step(double(frames.count), "frame " + std::to_string(index));
    }
    description.text += range_text(frames) + list.text;
    if (!list.json.is_null())
        description.json["frames"] = std::move(list.json);
}

Description describe_sequence(const fs::path& folder, const DescribeOptions& options) {
    const std::vector<std::int64_t> indices = list_frames(folder);
    const std::string gaps = gaps_text(indices);
    const auto bytes = static_cast<double>(bytes_of(folder, indices));
    Description description;
    description.json = {{"kind", "sequence"}, {"folder", folder.string()},     {"count", indices.size()},
                        {"bytes", bytes},     {"present", runs_text(indices)}, {"missing", gaps}};
    description.text =
        shown(folder.string()) + formatted(": sequence of %zu frames, ", indices.size()) + bytes_text(bytes) + "\n";
    if (!indices.empty())
        description.text += "  present    " + runs_text(indices) + "\n";
    if (!gaps.empty())
        description.text += "  missing    " + gaps + "\n";
    add_manifest(folder, description);
    if (options.each_frame)
        add_each_frame(folder, indices, options, description);
    return description;
}

/// Returns how many.
std::size_t write_frame_pictures(const fs::path& file, const fs::path& folder, const DisplayTransform& display) {
    const Frame frame = read_exr(file);
    const auto write = [&](const std::string& plane) {
        const fs::path name = file.stem().string() + "." + plane + ".png";
        write_picture(folder / name, picture_of_plane(frame, plane, display).view());
    };
    for (const auto& [plane, image] : frame.planes)
        write(plane);
    for (const auto& [plane, image] : frame.ids)
        write(plane);
    return frame.planes.size() + frame.ids.size();
}

}  // namespace

std::vector<fs::path> sequences_in(const fs::path& folder) {
    if (is_sequence(folder))
        return {folder};
    std::vector<fs::path> sequences;
    for (const char* name : known_folders)
        if (is_sequence(folder / name))
            sequences.push_back(folder / name);
    if (sequences.empty())
        throw InputError(expected_found(
            folder.string(),
            "frame.NNNN.exr files or manifest.json, here or in centre/, left/, right/, small/, hidden/, patches/ or "
            "window/",
            "none"));
    return sequences;
}

Description describe_folder(const fs::path& folder, const DescribeOptions& options) {
    const std::vector<fs::path> sequences = sequences_in(folder);
    if (sequences.front() == folder)
        return describe_sequence(folder, options);
    Description all;
    all.json = {{"kind", "render"}, {"folder", folder.string()}, {"sequences", nlohmann::json::array()}};
    for (const fs::path& sequence : sequences) {
        Description one = describe_sequence(sequence, options);
        all.text += one.text;
        all.json["sequences"].push_back(std::move(one.json));
    }
    return all;
}

std::size_t write_pictures(const fs::path& source, const fs::path& folder, cli::ProgressStyle style) {
    const DisplayTransform display;
    if (!fs::is_directory(source)) {
        if (!is_exr(source))
            throw InputError(expected_found("--pictures", "an EXR frame or a folder of frames",
                                            source.string() + ", another file (play writes the views of a stream)"));
        require_writable_folder(folder);
        return write_frame_pictures(source, folder, display);
    }
    std::size_t written = 0;
    for (const fs::path& sequence : sequences_in(source)) {
        // The pictures of a render lie as its frames do.
        const fs::path target = sequence == source ? folder : folder / sequence.filename();
        require_writable_folder(target);
        const std::vector<std::int64_t> indices = list_frames(sequence);
        cli::Progress progress("pictures", double(indices.size()), style);
        double done = 0;
        for (const std::int64_t index : indices) {
            written += write_frame_pictures(sequence / frame_file_name(index), target, display);
            progress.step(++done, "frame " + std::to_string(index));
        }
    }
    return written;
}

}  // namespace equistream
