#pragma once
/// What a file of ours holds, in plain language and as JSON.
#include <equistream/frame.h>
#include <equistream/text.h>

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace equistream {

struct Description {
    std::string text;  ///< lines, each ended
    nlohmann::json json;
};

/// Every frame in full, rather than their range.
struct DescribeOptions {
    bool each_frame = false;
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
/// Times and positions that a run of frames covers; nothing for no frames.
std::string range_text(const std::vector<FrameInfo>& frames);
/// A line of each.
std::string each_text(const std::vector<FrameInfo>& frames);
nlohmann::json range_json(const std::vector<FrameInfo>& frames);
std::string bytes_text(double bytes);
/// Text out of a file, as a terminal may have it.
std::string shown(const std::string& text);

// Pictures of what a frame carries, for people who would rather look than read.

/// Writes FOLDER/frame.NNNN.PLANE.png for every plane of an EXR frame, or of every frame of a sequence's folder. Those
/// of a render's folder go into FOLDER/centre, FOLDER/hidden and so on.
void write_pictures(const std::filesystem::path& source, const std::filesystem::path& folder);

}  // namespace equistream
