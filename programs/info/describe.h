#pragma once
/// What a file of ours holds, in plain language and as JSON.
#include <equistream/frame.h>
#include <equistream/text.h>
#include <programs/cli/program.h>

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace equistream {

struct Description {
    std::string text;  ///< lines, each ended
    nlohmann::json json;
};

struct DescribeOptions {
    bool each_frame = false;  ///< in full, rather than their range
    bool json = false;        ///< lists of frames, which may be long, are made for the JSON alone; else for the text
    cli::ProgressStyle progress = cli::ProgressStyle::none;
};

Description describe_stream(const std::string& source, const DescribeOptions& options);
/// By its first bytes.
bool is_exr(const std::filesystem::path& file);
Description describe_exr(const std::filesystem::path& file);
/// The folder itself where it has frames, else its folders that have some, as a render leaves them. Throws InputError
/// where there are none.
std::vector<std::filesystem::path> sequences_in(const std::filesystem::path& folder);
/// A sequence's folder, or a render's folder of several.
Description describe_folder(const std::filesystem::path& folder, const DescribeOptions& options);

/// The parts that the others share.
std::string pose_text(const Pose& pose);
nlohmann::json frame_json(const FrameInfo& info);
/// What all frames of one recording have in common: camera, eye, head box, scene, exposure.
std::string shared_text(const FrameInfo& info);

/// What a report says of a run of frames. They are not kept: an hour has 100,000, and tables of patches are large.
struct FrameRun {
    std::int64_t count = 0;
    FrameInfo first;
    std::int64_t last_index = 0;
    double last_time_s = 0;
    glm::dvec3 low{}, high{};  ///< of the cameras' positions

    void add(const FrameInfo& frame);
};
/// Times and positions that it covers; nothing for no frames.
std::string range_text(const FrameRun& frames);
nlohmann::json range_json(const FrameRun& frames);
/// One more frame of a list: a line of text, or an element of JSON.
void list_frame(const FrameInfo& frame, const DescribeOptions& options, Description& list);

std::string bytes_text(double bytes);
/// Text out of a file, as a terminal may have it.
std::string shown(const std::string& text);

// Pictures of what a frame carries, for people who would rather look than read.

/// Writes FOLDER/frame.NNNN.PLANE.png for every plane of an EXR frame, or of every frame of a sequence's folder. Those
/// of a render's folder go into FOLDER/centre, FOLDER/hidden and so on. Returns how many.
std::size_t write_pictures(const std::filesystem::path& source, const std::filesystem::path& folder,
                           cli::ProgressStyle progress);

}  // namespace equistream
